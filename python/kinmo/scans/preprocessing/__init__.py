"""Preparation of scans for the networks: outlier removal and normalisation of position, scale and rotation."""
