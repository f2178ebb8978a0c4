"""The paper's method: mobility tree, candidate axes, axis selection, scores and refinement (paper, section 3.3).

The motion GNN of section 3.2 is in `kinmo.learning.motion_gnn`.
"""
