"""Procedural articulated shapes, written in the layouts of PartNet-Mobility, PartNet and DSG-Net.

Names, nesting, joints and flaws imitate those of real files, and the files go through the same readers. The shapes are training
data and ground truth for users who have little or no annotated data.
"""
