"""Small OBJ files of several parts."""

from __future__ import annotations

from pathlib import Path

TRIANGLE = "v {0} 0 0\nv {0} 1 0\nv {0} 0 1\nf -3 -2 -1\n"


def obj(path: Path, *lines: str) -> Path:
    """An OBJ file with a triangle after each line, each one at another place."""
    path.write_text("".join(f"{line}\n{TRIANGLE.format(i)}" for i, line in enumerate(lines)), encoding="utf-8")
    return path
