"""Exact distances between the parts of a shape, compared with python-fcl.

A shape has 30 parts of 1,280 to 6,144 triangles (2,905 on average). Both sides use one thread, build their trees anew in every
run, and look only at pairs whose boxes are within 5 % of the shape's diagonal. Distances must agree to 1e-9 diagonals.

Usage:
    python bench/adjacency.py [--quick]
"""

from __future__ import annotations

from common import best_time, option_parser, print_claims, print_table, ratio_claim, use_one_thread

use_one_thread()

import fcl
import numpy as np
import trimesh

from kinmo import _core
from part_meshes import MeshArrays

GOAL = 10.0
REACH = 0.05
"""Largest distance that is computed, in diagonals."""
AGREEMENT = 1e-9
"""Largest difference of distances, in diagonals."""


def parts(seed: int, count: int = 30) -> list[MeshArrays]:
    """Boxes, balls, cylinders, rings and capsules with random rotations on a crowded lattice."""
    rng = np.random.default_rng(seed)
    made = []
    for index in range(count):
        size = rng.uniform(0.2, 0.5, 3)
        mesh = [
            lambda s=size: trimesh.creation.box(s).subdivide().subdivide().subdivide().subdivide(),
            lambda s=size: trimesh.creation.icosphere(3, s[0]).subdivide_to_size(s[0] / 6),
            lambda s=size: trimesh.creation.cylinder(s[0] / 2, s[1], sections=96).subdivide().subdivide(),
            lambda s=size: trimesh.creation.torus(s[0], s[1] / 4, 45, 22),
            lambda s=size: trimesh.creation.capsule(s[0], s[1] / 2, count=(32, 32)),
        ][index % 5]()
        mesh.apply_transform(trimesh.transformations.random_rotation_matrix(rng.uniform(size=3)))
        mesh.apply_translation(0.55 * np.array([index % 3, index // 3 % 3, index // 9]) + rng.uniform(-0.05, 0.05, 3))
        made.append((np.ascontiguousarray(mesh.vertices), mesh.faces.astype(np.uint32)))
    return made


def diagonal_of(shape: list[MeshArrays]) -> float:
    """Diagonal of the box of all parts."""
    vertices = np.concatenate([part[0] for part in shape])
    return float(np.linalg.norm(np.ptp(vertices, axis=0)))


def ours(shape: list[MeshArrays], within: float) -> dict[tuple[int, int], float]:
    """Distances by kinmo, by pair of parts."""
    meshes = _core.Meshes([part[0] for part in shape], [part[1] for part in shape])
    pairs, distances, _, _ = _core.part_distances(meshes, max_distance=within)
    return {(int(a), int(b)): float(d) for (a, b), d in zip(pairs, distances, strict=True)}


def peer(shape: list[MeshArrays], within: float) -> dict[tuple[int, int], float]:
    """Distances by FCL, by pair of parts. FCL returns -1 where surfaces cross."""
    objects = []
    for vertices, faces in shape:
        model = fcl.BVHModel()
        model.beginModel(len(vertices), len(faces))
        model.addSubModel(vertices, faces)
        model.endModel()
        objects.append(fcl.CollisionObject(model))
    low = np.array([part[0].min(axis=0) for part in shape])
    high = np.array([part[0].max(axis=0) for part in shape])
    result = {}
    for a in range(len(shape)):
        for b in range(a + 1, len(shape)):
            gap = np.maximum(np.maximum(low[b] - high[a], low[a] - high[b]), 0)
            if gap @ gap <= within * within:
                distance = fcl.distance(objects[a], objects[b], fcl.DistanceRequest(), fcl.DistanceResult())
                if distance <= within:
                    result[a, b] = max(distance, 0.0)
    return result


def main() -> None:
    """Compare the distances, then the times."""
    quick = option_parser(__doc__, "one shape, two repeats").parse_args().quick
    shapes = [parts(seed) for seed in range(1 if quick else 5)]
    rows = []
    for index, shape in enumerate(shapes):
        diagonal = diagonal_of(shape)
        within = REACH * diagonal
        found, expected = ours(shape, within), peer(shape, within)
        # A pair at the very limit may be found by either side alone.
        inner = [pair for pair in found.keys() | expected.keys() if found.get(pair, expected.get(pair, 0)) < 0.999 * within]
        difference = max(abs(found[pair] - expected[pair]) for pair in inner) / diagonal
        repeats = 2 if quick else 5
        times = [1e3 * best_time(lambda f=run, s=shape, w=within: f(s, w), repeats) for run in (ours, peer)]
        triangles, touching = sum(len(part[1]) for part in shape), sum(distance == 0 for distance in found.values())
        rows.append((index, triangles, len(found), touching, difference, *times))
    print_table(("shape", "triangles", "pairs", "touching", "largest difference", "kinmo (ms)", "fcl (ms)"), rows)
    worst = max(row[4] for row in rows)
    if worst > AGREEMENT:
        raise SystemExit(f"distances differ by {worst:.1e} diagonals")
    mine, theirs = (float(np.mean([row[column] for row in rows])) for column in (5, 6))
    claim = f"exact part distances compared with python-fcl ({worst:.0e} diagonals apart), trees included, ms"
    print_claims(ratio_claim(claim, ours=mine, peer=theirs, goal=GOAL))


if __name__ == "__main__":
    main()
