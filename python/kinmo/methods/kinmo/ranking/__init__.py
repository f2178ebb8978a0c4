"""Ranking networks: probabilities of all candidate joints of a shape's bodies or nodes, and of their being at rest."""
