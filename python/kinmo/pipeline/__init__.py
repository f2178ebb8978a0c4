"""The stages that the command line runs: each reads the workspace, calls what does the work, and records what it made."""
