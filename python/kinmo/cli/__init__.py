"""The command line: it parses options, runs stages, and prints results."""

import sys


def main() -> None:
    """Run the program; never returns. Ctrl-C works from the first import on."""
    try:
        from kinmo.cli.app import main as run
    except KeyboardInterrupt:
        print("kinmo: interrupted", file=sys.stderr)
        sys.exit(130)
    run()


__all__ = ["main"]
