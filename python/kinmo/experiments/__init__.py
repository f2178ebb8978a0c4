"""Experiments of the paper and around it: baselines, ablations, Tables 2 to 4, sensors, self-training, pseudo-label studies.

Product code never imports this package.
"""
