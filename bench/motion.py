"""Points moved by candidate joints, compared with a float32 einsum: 15 candidates x 8 displacements x 4,096 points, one thread.

The einsum gets its matrices ready-made; kinmo builds them within the timed call. The einsum is timed without and with BLAS
(`optimize=True`). The claim is about the one without.

Usage:
    python bench/motion.py [--quick]
"""

from __future__ import annotations

from common import best_time, option_parser, print_claims, print_table, ratio_claim, use_one_thread

use_one_thread()

import numpy as np
from scipy.spatial.transform import Rotation

from kinmo import _core

GOAL = 5.0
CANDIDATES, DISPLACEMENTS, POINTS = 15, 8, 4096
AGREEMENT = 1e-5


def main() -> None:
    """Compare the moved points, then the times."""
    repeats = 5 if option_parser(__doc__, "few repeats").parse_args().quick else 40
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

    def einsum(*, blas: bool = False) -> np.ndarray:
        return np.einsum("cdij,nj->cdni", matrices, points, optimize=blas) + offsets

    difference = float(np.abs(ours() - einsum()).max())
    if difference > AGREEMENT:
        raise SystemExit(f"moved points differ by {difference:.1e}")
    print(f"largest difference of points {difference:.1e}")
    runs = {"kinmo": ours, "einsum": einsum, "einsum with BLAS": lambda: einsum(blas=True)}
    times = {name: 1e3 * best_time(run, repeats) for name, run in runs.items()}
    print_table(("", "time (ms)", "ratio"), [(name, time, time / times["kinmo"]) for name, time in times.items()])
    claim = (
        f"moved points compared with a float32 einsum, ms ({times['einsum with BLAS'] / times['kinmo']:.1f} times with BLAS)"
    )
    print_claims(ratio_claim(claim, ours=times["kinmo"], peer=times["einsum"], goal=GOAL))


if __name__ == "__main__":
    main()
