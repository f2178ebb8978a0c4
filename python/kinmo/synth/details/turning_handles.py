"""Handles that turn about their stem: levers, crosses, wheels, tees and lobed knobs of taps, valves and clamps."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import (
    Y,
    box,
    cylinder,
    ellipsoid,
    extrude,
    lathe,
    move,
    rounded_path,
    sweep,
    sweep_outline,
    torus,
    turn,
)

FLAT_BAR_OUTLINE = np.array([[0.5, 0.15], [-0.5, 0.15], [-0.5, -0.15], [0.5, -0.15]])
"""Outline [4, 2] of a flat bar, to sweep."""


def revolved_cap(draw: Draw, radius: float, height: float) -> Mesh:
    """A cap about y with its foot at the origin: a drum, a cone, a dome, a bell or a block."""
    segments = draw.pick([12, 16, 24])
    profiles = {
        "drum": [[0, 0], [1, 0], [1, 0.92], [0.92, 1], [0, 1]],
        "cone": [[0, 0], [1, 0], [1, 0.2], [0.65, 1], [0, 1]],
        "dome": [[0, 0], [1, 0], [1, 0.4], [0.9, 0.7], [0.6, 0.92], [0, 1]],
        "bell": [[0, 0], [1, 0], [0.9, 0.15], [0.55, 0.4], [0.5, 0.7], [0.75, 0.85], [0.5, 1], [0, 1]],
        "square": [],
    }
    kind = draw.pick(list(profiles), [4, 2, 3, 2, 1])
    if kind == "square":
        return box((1.8 * radius, height, 1.8 * radius), (0, 0.5 * height, 0))
    return lathe(np.array(profiles[kind], float) * (radius, height), segments)


def lever(draw: Draw, length: float, thickness: float, height: float) -> list[Mesh]:
    """Meshes of an arm from the y axis at `height` to +z: a rod, or a flat, curved or tapered blade."""
    rise = length * draw.pick([0.0, draw.between(0.0, 0.5), draw.between(-0.25, 0.0)], [2, 4, 1])
    bend = draw.between(-0.15, 0.25) * length
    corners = np.array([(0, height, 0), (0, height + 0.5 * rise + bend, 0.5 * length), (0, height + rise, length)])
    path = rounded_path(corners, 0.45 * length, 7)
    if draw.chance(0.45):
        rods = [sweep(path, thickness * np.linspace(1.0, draw.between(0.5, 1.2), len(path)), draw.pick([8, 12]))]
        if draw.chance(0.35):
            size = thickness * draw.between(1.3, 1.9)
            rods.append(ellipsoid((size, size, size), path[-1], 12, 8))
        return rods
    widths = thickness * draw.between(2.0, 5.0) * np.linspace(1.0, draw.between(0.5, 1.3), len(path))
    # `sweep_outline` puts the outline's first axis across the path and the smallest component of its start: x here.
    return [sweep_outline(path, FLAT_BAR_OUTLINE[:, ::-1] if _starts_sideways(path) else FLAT_BAR_OUTLINE, widths)]


def _starts_sideways(path: np.ndarray) -> bool:
    """True if a sweep along `path`, in the plane x = 0, puts its outline's first axis in that plane rather than along x."""
    tangent = path[1] - path[0]
    first = np.cross(tangent, np.eye(3)[int(np.argmin(np.abs(tangent)))])
    return bool(abs(first[0]) < 0.5 * np.linalg.norm(first))


def spokes(draw: Draw, radius: float, thickness: float, height: float) -> list[Mesh]:
    """Two to five arms about the y axis at `height`, sometimes with balls at their ends."""
    count = draw.pick([2, 3, 4, 5], [3, 2, 5, 1])
    arm = [cylinder(thickness, radius, "z", (0, height, 0.5 * radius), 10, top_radius=thickness * draw.between(0.7, 1.4))]
    if draw.chance(0.5):
        arm.append(ellipsoid(np.full(3, thickness * draw.between(1.3, 1.8)), (0, height, radius), 10, 6))
    start = draw.pick([0.0, 45.0, draw.between(0.0, 90.0)])
    return [turn(piece, Y, start + 360.0 * i / count) for i in range(count) for piece in arm]


def wheel(draw: Draw, radius: float, thickness: float, height: float) -> list[Mesh]:
    """A rim on spokes about the y axis."""
    rim = torus(radius, thickness, "y", (0, height, 0), 24, 8)
    bar = cylinder(0.8 * thickness, 2 * radius, "z", (0, height, 0), 8)
    count = draw.integer(1, 3)
    return [rim, *(turn(bar, Y, 180.0 * i / count) for i in range(count))]


def lobed_knob(draw: Draw, radius: float, height: float) -> list[Mesh]:
    """A grip with lobes about the y axis, with its foot at the origin."""
    lobes, depth = draw.integer(3, 8), draw.between(0.05, 0.25)
    angle = np.linspace(0, 2 * np.pi, 8 * lobes, endpoint=False)
    reach = radius * (1 - depth + depth * np.cos(lobes * angle))
    outline = np.stack([reach * np.cos(angle), reach * np.sin(angle)], axis=1)
    return [extrude(outline, height, "y", (0, 0.5 * height, 0))]


def turning_handle(draw: Draw, radius: float, height: float) -> list[Mesh]:
    """Meshes of a handle about the y axis, with its foot at the origin, a reach of about `radius`, and a hub of `height`."""
    thickness = radius * draw.between(0.09, 0.16)
    kind = draw.pick(["lever", "spokes", "wheel", "lobed", "cap", "tee"], [5, 4, 2, 3, 2, 2])
    if kind == "lobed":
        return lobed_knob(draw, 0.6 * radius, height)
    if kind == "cap":
        return [revolved_cap(draw, 0.55 * radius, height)]
    hub = revolved_cap(draw, draw.between(1.4, 2.5) * thickness, height)
    if kind == "lever":
        return [hub, *lever(draw, radius, thickness, draw.between(0.5, 0.95) * height)]
    if kind == "spokes":
        return [hub, *spokes(draw, 0.8 * radius, thickness, draw.between(0.5, 0.9) * height)]
    if kind == "wheel":
        return [hub, *wheel(draw, 0.8 * radius, 0.8 * thickness, draw.between(0.5, 0.9) * height)]
    bar = cylinder(thickness, 1.4 * radius, draw.pick(["x", "z"]), (0, height, 0), 10)
    return [hub, move(bar, (0, draw.between(-0.3, 0.0) * height, 0))]
