"""Self-training, the paper's ANCSH (Semi): supervised networks label the scans of unlabelled objects."""
