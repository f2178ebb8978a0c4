"""Networks, and what trains them. Nothing here knows of files other than checkpoints and weights."""
