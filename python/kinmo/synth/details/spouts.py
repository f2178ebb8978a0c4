"""Spouts of faucets: their path, and their tube, head and mouth along it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import rounded_path, sweep
from kinmo.synth.synth_object import Motion, Node, slider


def arm_path(draw: Draw, reach: float, height: float, start: float) -> NDArray[np.float64]:
    """Path [N, 3] of a spout from the post at `height` to +z: straight, arched, or kinked down at its end."""
    rise = draw.between(-0.1, 0.35) * reach
    kind = draw.pick(["straight", "arched", "kinked"])
    corners = [(0, height, 0.3 * start), (0, height + rise, reach)]
    if kind == "arched":
        corners = [corners[0], (0, height + abs(rise) + 0.25 * reach, 0.6 * reach), (0, height + 0.5 * rise - 0.05, reach)]
    elif kind == "kinked":
        corners.append((0, height + rise - draw.between(0.08, 0.25), reach + draw.between(0.0, 0.1)))
    return rounded_path(np.array(corners), 0.3 * reach, 8)


def neck_path(draw: Draw, foot: float) -> NDArray[np.float64]:
    """Path [N, 3] of a gooseneck, or of a mast with an arm, from the height `foot` up, over to +z and down."""
    reach, mast = draw.ratio(0.25, 1.1), foot + draw.ratio(0.1, 1.3)
    if draw.chance(0.6):
        angle = np.radians(np.linspace(0.0, draw.between(120.0, 215.0), 16))
        over = np.stack([np.sin(angle), 1.0 - np.cos(angle)], axis=1) * (0.5 * reach)
        bend = np.column_stack([np.zeros(16), mast + over[:, 0], over[:, 1]])
        return np.concatenate([[(0, foot, 0), (0, 0.5 * (foot + mast), 0)], bend])
    end = (0, mast + draw.between(-0.1, 0.3), reach)
    return rounded_path(np.array([(0, foot, 0), (0, mast, 0), end, (0, end[1] - 0.08, reach + 0.01)]), 0.12, 6)


def add_spout(draw: Draw, spout: Node, path: NDArray[np.float64], radius: float) -> None:
    """Add a tube along a path [N, 3] to the node `spout`, and sometimes a head and a mouth at its end."""
    taper = np.linspace(1.0, draw.between(0.6, 1.05), len(path))
    spout.add("tube", sweep(path, radius * taper, draw.pick([8, 12, 16, 20])))
    tip = path[-1] - path[-2]
    tip /= np.linalg.norm(tip)
    end = radius * taper[-1]
    if draw.chance(0.45):
        ends = np.stack([path[-1] - 0.3 * end * tip, path[-1] + draw.between(0.3, 1.5) * end * tip])
        spout.add("head", sweep(ends, end * draw.between(1.05, 1.3), 16))
    if draw.chance(0.6):
        ends = np.stack([path[-1], path[-1] + draw.between(1.5, 1.8) * end * tip])
        spout.add("mouth", sweep(ends, 0.8 * end, 14))


def pull_out_head(draw: Draw, path: NDArray[np.float64], radius: float) -> tuple[list[Mesh], Motion]:
    """Meshes of a spray head at the end of a spout's path [N, 3], and its slider along the direction of that end."""
    tip = path[-1] - path[-2]
    tip /= np.linalg.norm(tip)
    long = radius * draw.ratio(1.5, 6.0)
    ends = path[-1] + np.outer([-0.3 * long, 0.1 * long, 0.7 * long], tip)
    pieces = [sweep(ends, radius * np.array([0.9, 1.05, draw.between(1.05, 1.6)]), draw.pick([10, 16]))]
    if draw.chance(0.4):
        pieces.append(sweep(path[-1] + np.outer([0.7 * long, 0.8 * long], tip), 0.85 * radius, 14))
    return pieces, slider(tip, 0.0, long * draw.between(1.0, 3.0), rest=draw.pick([0.0, 0.8 * long], [6, 1]))
