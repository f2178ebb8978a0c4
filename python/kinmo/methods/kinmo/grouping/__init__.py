"""Grouping of parts into bodies: a network on the contact graph, and the merge tree of its most certain pairs."""
