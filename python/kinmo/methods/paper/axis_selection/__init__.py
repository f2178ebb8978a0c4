"""The axis-selection network: how plausible a candidate axis looks when the part is moved along it (paper, section 3.3)."""
