"""Exact distances between the parts of a shape, against python-fcl pruned by boxes.

30 parts of 1,280 to 6,144 triangles (2,905 in the mean), one thread, trees built anew on both sides in every run. Both
look only at pairs whose boxes are within 5 % of the diagonal. Peer: `pip install python-fcl`.

    RAYON_NUM_THREADS=1 python bench/adjacency.py [--quick]
"""

from __future__ import annotations

import argparse
import json
import os

os.environ["RAYON_NUM_THREADS"] = "1"

import fcl
import numpy as np
import trimesh
from numpy.typing import NDArray

from kinmo import _core
from timing import best_time

GOAL = 10.0
SHARE = 0.05
AGREEMENT = 1e-9
MeshArrays = tuple[NDArray[np.float64], NDArray[np.uint32]]


def parts(seed: int, count: int = 30) -> list[MeshArrays]:
    """Boxes, balls, cylinders, rings and capsules, turned at random on a crowded lattice."""
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
    """Distances by kinmo."""
    meshes = _core.Meshes([part[0] for part in shape], [part[1] for part in shape])
    pairs, distances, _, _ = _core.part_distances(meshes, max_distance=within)
    return {(int(a), int(b)): float(d) for (a, b), d in zip(pairs, distances, strict=True)}


def peer(shape: list[MeshArrays], within: float) -> dict[tuple[int, int], float]:
    """Distances by FCL, which says -1 where surfaces cross."""
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
    """Compares distances, then times."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="one shape, two repeats")
    quick = parser.parse_args().quick
    shapes = [parts(seed) for seed in range(1 if quick else 5)]
    print(f"{'shape':>5} {'triangles':>9} {'pairs':>5} {'touch':>5} {'worst difference':>16} {'kinmo ms':>9} {'fcl ms':>9}")
    mine, theirs, worst = 0.0, 0.0, 0.0
    for index, shape in enumerate(shapes):
        diagonal = diagonal_of(shape)
        within = SHARE * diagonal
        found, expected = ours(shape, within), peer(shape, within)
        # A pair at the very limit may fall to either side.
        inner = [pair for pair in found.keys() | expected.keys() if found.get(pair, expected.get(pair, 0)) < 0.999 * within]
        difference = max(abs(found[pair] - expected[pair]) for pair in inner) / diagonal
        worst = max(worst, difference)
        repeats = 2 if quick else 5
        times = [1e3 * best_time(lambda f=run, s=shape, w=within: f(s, w), repeats) for run in (ours, peer)]
        mine, theirs = mine + times[0], theirs + times[1]
        triangles = sum(len(part[1]) for part in shape)
        touching = sum(distance == 0 for distance in found.values())
        print(f"{index:5} {triangles:9} {len(found):5} {touching:5} {difference:16.1e} {times[0]:9.2f} {times[1]:9.1f}")
    if worst > AGREEMENT:
        raise SystemExit(f"distances differ by {worst:.1e} diagonals")
    print(
        json.dumps(
            {
                "claim": f"exact part distances as python-fcl's ({worst:.0e} diagonals apart), build included, ms",
                "ours": mine / len(shapes),
                "peer": theirs / len(shapes),
                "ratio": theirs / mine,
                "goal": GOAL,
                "met": theirs / mine >= GOAL,
            }
        )
    )


if __name__ == "__main__":
    main()
