"""Mobilities as files that other programs read."""
