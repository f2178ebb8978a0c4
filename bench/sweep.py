"""Free travel along 60 candidate joints of one part, compared with a budget of 20 ms, one thread.

The scene is a door in its frame with a stop, a shelf and a back, in parts of 3,072 triangles. No library offers this, so the
peer is the budget of shape preparation. The free travel of the true hinge is checked against the measures of the scene.

Usage:
    python bench/sweep.py [--quick]
"""

from __future__ import annotations

from common import best_time, option_parser, print_claims, print_table, ratio_claim, use_one_thread

use_one_thread()

import numpy as np
import trimesh

from kinmo import _core

BUDGET_MS = 20.0
CANDIDATES = 60
STOP_ANGLE = 1.2
"""Angle of the stop from the closed door, in radians."""


def block(extents: tuple[float, ...], center: tuple[float, ...]) -> trimesh.Trimesh:
    """A box of 3,072 triangles."""
    solid = trimesh.creation.box(extents)
    for _ in range(4):
        solid = solid.subdivide()
    solid.apply_translation(center)
    return solid


def scene() -> _core.Meshes:
    """A door and its surroundings. The door is mesh 0; it opens towards +z about a hinge along y at x = 0."""
    stop = block((0.3, 0.3, 0.04), (0.7, 0, 0))
    stop.apply_transform(trimesh.transformations.rotation_matrix(-STOP_ANGLE, (0, 1, 0)))
    solids = [
        block((1, 2, 0.04), (0.5, 0, 0)),
        block((0.1, 2, 0.1), (-0.05, 0, 0)),
        block((0.1, 2, 0.1), (1.05, 0, 0)),
        block((1.2, 0.1, 0.1), (0.5, 1.05, 0)),
        block((1, 0.05, 0.4), (0.5, 0.3, -0.25)),
        block((1.2, 2, 0.05), (0.5, 0, -0.5)),
        stop,
    ]
    vertices = [np.ascontiguousarray(solid.vertices) for solid in solids]
    return _core.Meshes(vertices, [np.ascontiguousarray(solid.faces, np.uint32) for solid in solids])


def main() -> None:
    """Check the true hinge, then time all candidates."""
    repeats = 3 if option_parser(__doc__, "few repeats").parse_args().quick else 15
    meshes = scene()
    rng = np.random.default_rng(0)
    kinds = (np.arange(CANDIDATES) % 3 == 2).astype(np.uint8)
    directions = np.eye(3)[rng.integers(0, 3, CANDIDATES)]
    pivots = np.array([0, -1, -0.02]) + np.array([1, 2, 0.04]) * rng.integers(0, 2, (CANDIDATES, 3))
    kinds[0], directions[0], pivots[0] = 0, [0, -1, 0], [0, 0, 0]
    limits = np.where(kinds == 0, np.pi / 2, 1.0)

    def travel() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return _core.sweep(meshes, [0], list(range(1, len(meshes))), kinds, directions, pivots, -limits, limits)

    free = travel()[1][0]
    expected = STOP_ANGLE - 2 * np.arcsin(0.02 / 0.55)
    print(f"true hinge: free up to {np.degrees(free):.1f} degrees, {np.degrees(expected):.1f} by the measures of the scene")
    if abs(free - expected) > 0.06:
        raise SystemExit("the free travel of the true hinge is wrong")
    ours = 1e3 * best_time(travel, repeats)
    print_table(("candidates", "time (ms)", "a candidate (ms)"), [(CANDIDATES, ours, ours / CANDIDATES)])
    print_claims(
        ratio_claim(f"free travel of {CANDIDATES} candidates within the budget, ms", ours=ours, peer=BUDGET_MS, goal=1.0)
    )


if __name__ == "__main__":
    main()
