"""Depth scans of articulated objects: cameras, poses of the parts, renderers, and the labelled frames they give."""
