"""The motion GNN: a motion type, an axis direction and a pivot for every pair of sibling parts (paper, section 3.2)."""
