"""Axis selection network: feasibility score s^f of candidate axes, by a Siamese network (paper, section 3.3)."""
