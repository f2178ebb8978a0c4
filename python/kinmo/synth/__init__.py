"""Procedural articulated shapes: names, nesting, joints and flaws as PartNet's and PartNet-Mobility's files have them.

Ground truth for people without data, and the prior for people with little. The files go through the same readers as real ones.
"""
