"""Reading of one shape from a file or folder."""

from __future__ import annotations

from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.core.frames import Axis
from kinmo.core.shape import Shape
from kinmo.io.discover import discover
from kinmo.io.readers.stated_facts import StatedFacts


def load(
    path: Path | str,
    *,
    category: str | None = None,
    up: Axis | None = None,
    front: Axis | None = None,
    metres_per_unit: float | None = None,
    labels: Path | str | None = None,
) -> Shape:
    """Read one shape.

    What is None comes from the file or its format, or is guessed. `Shape.guesses` lists the guesses.

    Args:
        path: File or folder of the shape, in any input format (docs/reference/formats.md).
        category: Category of the object, in any spelling.
        up: Axis of the file's frame that points up: "x", "y", "z", "-x", "-y" or "-z". Without a front, the front is then at
            +z for "y" and at -y for "z".
        front: Axis of the file's frame that points to the viewer, like `up`.
        metres_per_unit: Length of a unit of the file, in metres.
        labels: An .npy file with one integer per triangle of the file, over all its meshes in file order. Equal integers
            become a part.

    Returns:
        The shape, in the frame and units of its file. `repairs` lists what the reader had to repair.

    Raises:
        InputError: There is no shape, there are several, or it cannot be read.

    Example:
        >>> shape = kinmo.load("cabinet.glb")
        >>> [part.name for part in shape.parts]
    """
    facts = StatedFacts(category, up, front, metres_per_unit, None if labels is None else Path(labels))
    found = list(discover(Path(path)))
    if len(found) != 1:
        problem = f"found {len(found)} shapes, the first at {found[0].path}" if found else "found no shape"
        raise InputError(path, f"expected one shape: {problem}")
    return found[0].read(facts)
