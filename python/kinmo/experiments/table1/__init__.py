"""Rows of Table 1 besides the trained methods: upper bounds, a rule without learning, boosted trees, ablations."""
