"""Stages that work on scans: rendering, training, evaluation and prediction."""
