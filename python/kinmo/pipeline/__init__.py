"""The stages behind the API and the command line. Each reads a workspace, does what is left to do, and records it."""
