"""Interaction regions of touching pairs of bodies, compared with SciPy's Voronoi diagram for the same definition.

There are 200 pairs of bodies of real objects within 1 % of the object's diagonal, drawn with a fixed seed. Each body has 1,024
samples, and both sides use one thread. The regions of a pair agree if their centroids are within 0.01 diagonals of the pair's
box. Without real objects the pairs are procedural, and the claim says so.

Usage:
    python bench/interaction.py [--data DIR] [--quick]
"""

from __future__ import annotations

import sys
from pathlib import Path

from common import REAL_OBJECTS, best_time, option_parser, print_claims, print_table, ratio_claim, use_one_thread

use_one_thread()

import numpy as np
import trimesh
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.shape import Shape
from kinmo.io.discover import discover

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))
import scipy_ibs

GOAL = 30.0
AGREEING_SHARE = 0.95
TOLERANCE = 0.01
SAMPLES = 1024
CONTACT = 0.01
"""Largest distance of touching bodies, in diagonals."""
PAIR = np.array([[0, 1]], np.uint32)
Pair = tuple[trimesh.Trimesh, trimesh.Trimesh]


def bodies_of(shape: Shape) -> list[trimesh.Trimesh]:
    """The bodies of an annotated object that have geometry."""
    bodies = []
    for body in shape.mobility.bodies if shape.mobility is not None else ():
        meshes = [mesh for leaf in body.leaves if (mesh := shape.parts[leaf].mesh) is not None]
        if meshes:
            bodies.append(trimesh.util.concatenate([trimesh.Trimesh(m.vertices, m.faces, process=False) for m in meshes]))
    return bodies


def touching(bodies: list[trimesh.Trimesh]) -> list[Pair]:
    """Pairs of bodies within 1 % of the diagonal of all bodies."""
    if len(bodies) < 2:
        return []
    vertices = [np.ascontiguousarray(body.vertices, float) for body in bodies]
    meshes = _core.Meshes(vertices, [np.ascontiguousarray(body.faces, np.uint32) for body in bodies])
    diagonal = float(np.linalg.norm(np.ptp(np.concatenate(vertices), axis=0)))
    pairs, _, _, _ = _core.part_distances(meshes, max_distance=CONTACT * diagonal)
    return [(bodies[a], bodies[b]) for a, b in pairs]


def procedural_pair(rng: np.random.Generator) -> Pair:
    """A board or a knob of random size at a random place on the face of a body."""
    size, part = rng.uniform(0.5, 2, 3), rng.uniform(0.03, 0.6, 3)
    body, board = trimesh.creation.box(size), trimesh.creation.box(part)
    board.apply_translation([*rng.uniform(-0.4, 0.4, 2) * size[:2], (size[2] + part[2]) / 2])
    return board, body


def pairs_of(data: Path, count: int) -> tuple[list[Pair], str]:
    """`count` touching pairs, and "real" or "procedural"."""
    rng = np.random.default_rng(0)
    sources = sorted(discover(data), key=lambda source: source.path) if data.is_dir() else []
    if not sources:
        return [procedural_pair(rng) for _ in range(count)], "procedural"
    order = rng.permutation(len(sources))
    if count < 50:
        order = order[:count]
    pairs = [pair for index in order for pair in touching(bodies_of(sources[index].read()))]
    return [pairs[index] for index in rng.permutation(len(pairs))[:count]], "real"


def compare(pair: Pair, seed: int) -> tuple[float, float, float]:
    """Distance of the centroids in diagonals, and the times of kinmo and SciPy in ms."""
    points: NDArray[np.float64] = np.stack([trimesh.sample.sample_surface(body, SAMPLES, seed=seed)[0] for body in pair])
    expected, found = scipy_ibs.interaction_region(*points), _core.interaction_regions(points, PAIR)
    error = float(np.linalg.norm(found.centroids[0] - expected.centroid) / expected.diagonal)
    ours = best_time(lambda: _core.interaction_regions(points, PAIR), 2)
    peer = best_time(lambda: scipy_ibs.interaction_region(*points), 1)
    return error, 1e3 * ours, 1e3 * peer


def main() -> None:
    """Compare the centroids, then the times."""
    parser = option_parser(__doc__, "20 pairs")
    parser.add_argument("--data", type=Path, default=REAL_OBJECTS, help="folder of the real objects")
    options = parser.parse_args()
    pairs, kind = pairs_of(options.data, 20 if options.quick else 200)
    errors, mine, theirs = np.array([compare(pair, seed) for seed, pair in enumerate(pairs)]).T
    agreeing = int((errors <= TOLERANCE).sum())
    print(f"{len(pairs)} {kind} touching pairs, {SAMPLES} samples a body")
    print(f"{agreeing} centroids within {TOLERANCE} diagonals: median {np.median(errors):.1e}, most {max(errors):.4f}")
    rows = [(n, float(t.mean()), float(np.median(t)), float(t.max())) for n, t in (("kinmo", mine), ("SciPy", theirs))]
    print_table(("", "mean (ms)", "median (ms)", "most (ms)"), rows)
    if agreeing < AGREEING_SHARE * len(pairs):
        raise SystemExit("the regions do not agree")
    claim = (
        f"interaction region compared with SciPy's Voronoi diagram ({agreeing} of {len(pairs)} {kind} pairs agree), ms a pair"
    )
    print_claims(ratio_claim(claim, ours=float(mine.mean()), peer=float(theirs.mean()), goal=GOAL))


if __name__ == "__main__":
    main()
