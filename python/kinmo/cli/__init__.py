"""The command line: it parses and prints, and computes nothing."""

from kinmo.cli.app import main

__all__ = ["main"]
