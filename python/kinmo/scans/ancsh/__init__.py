"""ANCSH: parts, canonical coordinates and joints from the points of one depth scan (Li et al. 2020; paper, section 3.4)."""
