"""Scans in files: labelled frames on disk, depth scans of users, and SVG pictures."""
