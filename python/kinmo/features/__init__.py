"""Geometric features of parts and of candidate joints, shared by both methods."""
