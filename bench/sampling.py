"""Uniform surface samples, compared with Open3D's `sample_points_uniformly`, one thread each.

Thirty parts of 2,000 and of 50,000 triangles, 1,024 points a part. The samples of both must be uniform by area.

Usage:
    python bench/sampling.py [--quick]
"""

from __future__ import annotations

import sys

from common import Claim, best_times, option_parser, print_claims, print_table, ratio_claim, use_one_thread

use_one_thread()

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.stats import ks_2samp

from kinmo import _core

try:
    import open3d
except (ImportError, OSError) as error:
    sys.exit(
        f"Open3D cannot be imported ({error}). Install it with `pip install -r bench/requirements.txt`; "
        "it also needs system libraries (`apt-get install libusb-1.0-0 libgl1 libgomp1`)."
    )

PARTS, POINTS = 30, 1024
GOALS = {2_000: 4.0, 50_000: 2.5}
"""Ratio to reach, by number of triangles."""
MAX_UNEVENNESS = 0.06


def uneven_torus(triangles: int, rng: np.random.Generator) -> trimesh.Trimesh:
    """A torus with about this many triangles, under a random linear map that makes their areas differ widely."""
    sections = int(np.sqrt(triangles / 2))
    mesh = trimesh.creation.torus(1.0, 0.4, sections, sections)
    return trimesh.Trimesh(mesh.vertices @ rng.normal(size=(3, 3)), mesh.faces, process=False)


def unevenness(points: NDArray[np.float64], mesh: trimesh.Trimesh) -> float:
    """Largest Kolmogorov-Smirnov distance, over the coordinates, from a large sample by trimesh."""
    reference = trimesh.sample.sample_surface(mesh, 200_000, seed=0)[0]
    return max(float(ks_2samp(points[:, axis], reference[:, axis]).statistic) for axis in range(3))


def compare(triangles: int, rounds: int) -> Claim:
    """Check and time both on meshes of about this many triangles."""
    rng = np.random.default_rng(0)
    meshes = [uneven_torus(triangles, rng) for _ in range(PARTS)]
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
        if max(off.values()) > MAX_UNEVENNESS:
            sys.exit("the samples are not uniform by area")
    taken, peer = best_times(
        [
            lambda: _core.sample_surface(ours, POINTS),
            lambda: [np.asarray(m.sample_points_uniformly(POINTS).points) for m in peers],
        ],
        rounds,
    )
    claim = f"samples of {PARTS} parts of {triangles:,} triangles compared with Open3D, {POINTS} points a part, ms"
    return ratio_claim(claim, ours=1e3 * taken, peer=1e3 * peer, goal=GOALS[triangles])


def main() -> None:
    """Compare both numbers of triangles."""
    rounds = 3 if option_parser(__doc__, "few rounds").parse_args().quick else 100
    claims = [compare(triangles, rounds) for triangles in GOALS]
    rows = [(n, c["ours"], c["peer"], c["ratio"], c["goal"]) for n, c in zip(GOALS, claims, strict=True)]
    print_table(("triangles", "kinmo (ms)", "Open3D (ms)", "ratio", "goal"), rows)
    print_claims(*claims)


if __name__ == "__main__":
    main()
