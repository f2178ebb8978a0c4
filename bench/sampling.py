"""Uniform surface samples: kinmo against Open3D's `sample_points_uniformly`, one thread each.

    python bench/sampling.py [--quick]

Thirty parts of 2,000 and of 50,000 triangles, 1024 points a part. First checks that both spread their points over the
surface by area. Times are seconds of processor time, the least of several rounds in turns.
"""

from __future__ import annotations

import os

os.environ["RAYON_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = "1"

import argparse
import json
import sys
import time
from collections.abc import Callable

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.stats import ks_2samp

from kinmo import _core

try:
    import open3d
except (ImportError, OSError) as error:
    sys.exit(
        f"bench/sampling.py: Open3D cannot be imported ({error}). Install it with `pip install -r bench/requirements.txt`; "
        "it also needs the system library libusb-1.0 (`apt-get install libusb-1.0-0 libgl1 libgomp1`)."
    )

PARTS, POINTS = 30, 1024
GOALS = {2_000: 4.0, 50_000: 2.5}


def lump(triangles: int, rng: np.random.Generator) -> trimesh.Trimesh:
    """A torus with about that many triangles, squeezed and shorn so that their areas differ widely."""
    sections = int(np.sqrt(triangles / 2))
    mesh = trimesh.creation.torus(1.0, 0.4, sections, sections)
    return trimesh.Trimesh(mesh.vertices @ rng.normal(size=(3, 3)), mesh.faces, process=False)


def unevenness(points: NDArray[np.float64], mesh: trimesh.Trimesh) -> float:
    """Largest Kolmogorov-Smirnov distance, over the coordinates, to a large sample by trimesh."""
    reference = trimesh.sample.sample_surface(mesh, 200_000, seed=0)[0]
    return max(float(ks_2samp(points[:, axis], reference[:, axis]).statistic) for axis in range(3))


def least_times(runs: list[Callable[[], object]], rounds: int) -> list[float]:
    times = [[] for _ in runs]
    for _ in range(rounds):
        for run, taken in zip(runs, times, strict=True):
            start = time.process_time()
            run()
            taken.append(time.process_time() - start)
    return [min(taken) for taken in times]


def compare(triangles: int, rounds: int) -> dict[str, float | bool]:
    """Checks and times both on meshes of about so many triangles."""
    rng = np.random.default_rng(0)
    meshes = [lump(triangles, rng) for _ in range(PARTS)]
    ours = _core.Meshes([m.vertices for m in meshes], [m.faces.astype(np.uint32) for m in meshes])
    peers = [
        open3d.geometry.TriangleMesh(open3d.utility.Vector3dVector(m.vertices), open3d.utility.Vector3iVector(m.faces))
        for m in meshes
    ]
    if triangles <= 2_000:
        drawn = _core.sample_surface(ours, POINTS)[0][0].astype(float)
        theirs = np.asarray(peers[0].sample_points_uniformly(POINTS).points)
        off = {"kinmo": unevenness(drawn, meshes[0]), "Open3D": unevenness(theirs, meshes[0])}
        print("distance from uniform by area:", ", ".join(f"{name} {value:.3f}" for name, value in off.items()))
        if max(off.values()) > 0.06:
            sys.exit("bench/sampling.py: the samples are not uniform by area")
    taken, peer = least_times(
        [
            lambda: _core.sample_surface(ours, POINTS),
            lambda: [np.asarray(m.sample_points_uniformly(POINTS).points) for m in peers],
        ],
        rounds,
    )
    ratio = peer / taken
    print(f"{triangles:>9,} {taken * 1e3:>12.2f} {peer * 1e3:>12.2f} {ratio:>8.2f} {GOALS[triangles]:>6}")
    return {"ours": taken, "peer": peer, "ratio": ratio, "goal": GOALS[triangles], "met": ratio >= GOALS[triangles]}


def main() -> None:
    """Prints the table and the JSON line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer rounds")
    rounds = 3 if parser.parse_args().quick else 100
    print(f"{'triangles':>9} {'kinmo, ms':>12} {'Open3D, ms':>12} {'ratio':>8} {'goal':>6}")
    small, large = (compare(triangles, rounds) for triangles in GOALS)
    claim = f"sampling {PARTS} parts x {POINTS} points, one thread, against Open3D (2k triangles; 50k below)"
    print(json.dumps({"claim": claim, **small, "met": bool(small["met"] and large["met"]), "at_50k_triangles": large}))


if __name__ == "__main__":
    main()
