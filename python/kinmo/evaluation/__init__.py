"""What every figure means and how it is taken (docs/metrics.md)."""
