"""ANCSH: from the points of one depth scan to parts, their canonical coordinates, and joints (Li 2020)."""
