"""Reading of one shape from a file or folder."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.core.frames import UP_VECTORS, Up
from kinmo.core.shape import Shape
from kinmo.io.discover import discover


def load(path: Path | str, *, up: Up | None = None) -> Shape:
    """Read one shape.

    Args:
        path: File or folder of the shape, in any input format (docs/reference/formats.md).
        up: Axis of the file's frame that points up: "y" with the front at +z, or "z" with the front at -y. None for the
            format's own.

    Returns:
        The shape, in the frame and units of its file. `repairs` lists what the reader had to repair.

    Raises:
        InputError: There is no shape, there are several, or it cannot be read.

    Example:
        >>> shape = kinmo.load("cabinet.glb")
        >>> [part.name for part in shape.parts]
    """
    found = list(discover(Path(path)))
    if len(found) != 1:
        problem = f"found {len(found)} shapes, the first at {found[0].path}" if found else "found no shape"
        raise InputError(path, f"expected one shape: {problem}")
    shape = found[0].read()
    return shape if up is None else replace(shape, up=UP_VECTORS[up])
