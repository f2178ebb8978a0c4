"""Evaluation of trained methods on the test shapes of a workspace (paper, Table 1)."""
