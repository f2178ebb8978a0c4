"""The command line: it parses and prints, and computes nothing."""

import sys


def main() -> None:
    """Run the program; never returns. Ctrl-C is minded from the first import on."""
    try:
        from kinmo.cli.app import main as run
    except KeyboardInterrupt:
        print("kinmo: stopped", file=sys.stderr)
        sys.exit(130)
    run()


__all__ = ["main"]
