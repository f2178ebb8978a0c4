"""Metrics, test protocols and tables of results (docs/background/metrics.md)."""
