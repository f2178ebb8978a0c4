"""Resting postures of small objects: as they were built, turned about the vertical, or stood on an edge or end."""

from __future__ import annotations

from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, rotation_about
from kinmo.synth.synth_object import SynthObject


def turn_about_up(draw: Draw, shape: SynthObject, angles: tuple[float, ...] = (0.0, 90.0, 180.0, 270.0)) -> None:
    """Turn the object about the vertical by one of `angles` (degrees), in place."""
    shape.move(rotation_about(Y, draw.pick(angles)))


def lay_down(draw: Draw, shape: SynthObject) -> None:
    """Lay a flat object, built across y, on its face, or stand it on an end or an edge, in place."""
    posture = draw.pick(["flat", "on end", "on edge"], [5, 3, 1])
    if posture == "on end":
        shape.move(rotation_about(X, draw.pick([90.0, -90.0])))
    elif posture == "on edge":
        shape.move(rotation_about(Z, 90.0))
    turn_about_up(draw, shape)
