"""Depth scans of articulated objects: rendering, canonical poses, networks (ANCSH) and pose fitting (paper, section 3.4)."""
