"""Points moved by candidate joints, against a float32 einsum: 15 candidates x 8 displacements x 4096 points, one thread.

The peer is given its matrices; kinmo builds them in the timed call. `einsum` may go through BLAS (`optimize=True`) or not:
both are printed, the claim is against the plain call.

    RAYON_NUM_THREADS=1 OMP_NUM_THREADS=1 python bench/motion.py [--quick]
"""

from __future__ import annotations

import argparse
import json
import os

for variable in ("RAYON_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np
from scipy.spatial.transform import Rotation

from kinmo import _core
from timing import best_time

GOAL = 5.0
CANDIDATES, DISPLACEMENTS, POINTS = 15, 8, 4096
AGREEMENT = 1e-5


def main() -> None:
    """Compares the moved points, then times."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="a few repeats")
    repeats = 5 if parser.parse_args().quick else 40
    rng = np.random.default_rng(0)
    points = rng.uniform(-0.5, 0.5, (POINTS, 3)).astype(np.float32)
    kinds = (np.arange(CANDIDATES) % 3).astype(np.uint8)
    directions = rng.normal(size=(CANDIDATES, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    pivots = rng.uniform(-0.5, 0.5, (CANDIDATES, 3))
    angles, shifts = rng.uniform(-1.5, 1.5, (2, CANDIDATES, DISPLACEMENTS))
    angles[kinds == 1] = 0
    shifts[kinds == 0] = 0

    turns = Rotation.from_rotvec((directions[:, None] * angles[..., None]).reshape(-1, 3)).as_matrix()
    matrices = turns.reshape(CANDIDATES, DISPLACEMENTS, 3, 3)
    offsets = pivots[:, None] - np.einsum("cdij,cj->cdi", matrices, pivots) + directions[:, None] * shifts[..., None]
    matrices, offsets = matrices.astype(np.float32), offsets.astype(np.float32)[:, :, None]

    def ours() -> np.ndarray:
        return _core.move_points(points, kinds, directions, pivots, angles, shifts)

    def peer() -> np.ndarray:
        return np.einsum("cdij,nj->cdni", matrices, points) + offsets

    def peer_by_blas() -> np.ndarray:
        return np.einsum("cdij,nj->cdni", matrices, points, optimize=True) + offsets

    difference = float(np.abs(ours() - peer()).max())
    if difference > AGREEMENT:
        raise SystemExit(f"moved points differ by {difference:.1e}")
    times = {run.__name__: 1e3 * best_time(run, repeats) for run in (ours, peer, peer_by_blas)}
    print(f"largest difference {difference:.1e}")
    for name, milliseconds in times.items():
        print(f"{name:15} {milliseconds:8.2f} ms {milliseconds / times['ours']:6.1f} x")
    ratio = times["peer"] / times["ours"]
    claim = f"candidate transforms as a float32 einsum, ms ({times['peer_by_blas'] / times['ours']:.1f} x with BLAS)"
    result = {"claim": claim, "ours": times["ours"], "peer": times["peer"], "ratio": ratio, "goal": GOAL, "met": ratio >= GOAL}
    print(json.dumps(result))


if __name__ == "__main__":
    main()
