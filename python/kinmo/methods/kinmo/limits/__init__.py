"""Joint limits: a network that predicts how far a body travels along its joint."""
