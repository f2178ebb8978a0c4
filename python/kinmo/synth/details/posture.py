"""How a small thing lies: as it was built, turned about the upright, or stood on its end."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from kinmo.synth.draw import Draw
from kinmo.synth.model import Link, SynthObject
from kinmo.synth.primitives import X, Y, Z, transform
from kinmo.synth.primitives.place import rotation_about

ORIGIN = (0.0, 0.0, 0.0)


def carry(links: Iterable[Link], matrix: NDArray[np.float64]) -> None:
    """Move links, their joints with them, by a rigid transform [4, 4]."""
    for link in links:
        for leaf in link.leaves():
            leaf.pieces = [transform(piece, matrix) for piece in leaf.pieces]
        if link.motion is not None:
            link.motion = link.motion.moved_by(matrix)


def reorient(shape: SynthObject, matrix: NDArray[np.float64]) -> None:
    """Move the whole object by a rigid transform [4, 4]."""
    carry(shape.links, matrix)


def face(draw: Draw, shape: SynthObject, directions: tuple[float, ...] = (0.0, 90.0, 180.0, 270.0)) -> None:
    """Turn the object about the upright to one of `directions`, in degrees."""
    reorient(shape, rotation_about(Y, draw.pick(directions), ORIGIN))


def lay(draw: Draw, shape: SynthObject) -> None:
    """Lay a flat object that is built across y on its face, or stand it up along or across."""
    turned = draw.pick(["flat", "upright", "on edge"], [5, 3, 1])
    if turned == "upright":
        reorient(shape, rotation_about(X, draw.pick([90.0, -90.0]), ORIGIN))
    elif turned == "on edge":
        reorient(shape, rotation_about(Z, 90.0, ORIGIN))
    face(draw, shape)
