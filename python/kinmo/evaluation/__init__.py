"""Metrics, test protocols and tables of results (docs/metrics.md)."""
