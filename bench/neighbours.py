"""The nearest points of every point of clouds as networks see them, against torch's topk and SciPy's search tree, one thread.

64 clouds of 256 points with 8 neighbours are those that axis selection judges with `small`, 16 of 1,024 points with 20 those of
`paper`. First all three must find equally near points.

    python bench/neighbours.py [--quick]
"""

from __future__ import annotations

import argparse
import json
import os

for variable in ("RAYON_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np
import torch
from scipy.spatial import cKDTree

from kinmo import _core
from timing import best_time

SIZES = ((64, 256, 8), (16, 1024, 20))
AGREEMENT = 1e-5


def compare(batch: int, size: int, count: int, repeats: int) -> dict[str, float]:
    """Times by name, once all have found the same."""
    clouds = np.random.default_rng(0).normal(size=(batch, size, 3)).astype(np.float32)
    points = torch.from_numpy(clouds)

    def ours() -> np.ndarray:
        return _core.nearest_neighbours(clouds, count)

    def topk() -> np.ndarray:
        squared = points.square().sum(-1)
        affinity = torch.baddbmm(squared.neg().unsqueeze(1), points, points.transpose(1, 2), beta=1.0, alpha=2.0)
        return affinity.topk(count, dim=-1, sorted=False).indices.numpy()

    def tree() -> np.ndarray:
        return np.stack([cKDTree(cloud).query(cloud, count)[1] for cloud in clouds])

    def farthest(found: np.ndarray) -> np.ndarray:
        return np.stack([np.linalg.norm(c[f] - c[:, None], axis=2).max(1) for c, f in zip(clouds, found, strict=True)])

    expected = farthest(tree())
    for run in (ours, topk):
        difference = float(np.abs(farthest(run()) - expected).max())
        if difference > AGREEMENT:
            raise SystemExit(f"{run.__name__}: the farthest neighbours differ by {difference:.1e}")
    return {run.__name__: 1e3 * best_time(run, repeats) for run in (ours, topk, tree)}


def main() -> None:
    """Compares and times both sizes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="a few repeats")
    repeats = 3 if parser.parse_args().quick else 20
    torch.set_num_threads(1)
    for batch, size, count in SIZES:
        times = compare(batch, size, count, repeats)
        text = ", ".join(f"{name} {milliseconds:.1f} ms" for name, milliseconds in times.items())
        print(f"{batch} clouds of {size} points, {count} neighbours: {text}")
        claim = f"{count} neighbours in {batch} clouds of {size} points by topk, ms"
        print(
            json.dumps({"claim": claim, "ours": times["ours"], "peer": times["topk"], "ratio": times["topk"] / times["ours"]})
        )


if __name__ == "__main__":
    main()
