"""Rendered depth scans of articulated objects: cameras, joint states, renderers, sensor faults and labelled frames."""
