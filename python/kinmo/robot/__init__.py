"""Robots: articulated objects as simulators need them, in one neutral form that every export format is written from."""
