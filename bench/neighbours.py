"""The nearest points of every point of clouds as networks see them, against torch's topk and SciPy's search tree, one thread;
and the maxima of features over them, forward and backward, against torch's bags and its gathering.

64 clouds of 256 points with 8 neighbours are those that axis selection judges with `small`, 16 of 1,024 points with 20 those of
`paper`. First all must find equally near points, and the same maxima and gradients.

    python bench/neighbours.py [--quick]
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Callable
from functools import partial

for variable in ("RAYON_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np
import torch
from scipy.spatial import cKDTree

from kinmo import _core
from kinmo.learning.layers import gather_points, neighbour_max
from timing import best_time

SIZES = ((64, 256, 8), (16, 1024, 20))
WIDTH = 64
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


def compare_maxima(batch: int, size: int, count: int, repeats: int) -> dict[str, float]:
    """The same of the maxima of `WIDTH` features, with their gradients."""
    torch.manual_seed(0)
    distinct = torch.randperm(batch * size * WIDTH).float()  # of equal ones each way gives the gradient to others
    features, slopes = distinct.view(batch, size, WIDTH).requires_grad_(), torch.randn(batch, size, WIDTH)
    index = torch.from_numpy(_core.nearest_neighbours(torch.rand(batch, size, 3).numpy(), count))
    rows = (index + torch.arange(batch).view(-1, 1, 1) * size).flatten(0, 1)

    def ours() -> torch.Tensor:
        return neighbour_max(features, index)

    def bags() -> torch.Tensor:
        return torch.nn.functional.embedding_bag(rows, features.flatten(0, 1), mode="max").view_as(features)

    def gathered() -> torch.Tensor:
        return gather_points(features, index).amax(2)

    def both_ways(maxima: Callable[[], torch.Tensor]) -> tuple[torch.Tensor, torch.Tensor]:
        found = maxima()
        return found.detach(), torch.autograd.grad(found, features, slopes)[0]

    expected = both_ways(gathered)
    for run in (ours, bags):
        for found, wanted in zip(both_ways(run), expected, strict=True):
            difference = float((found - wanted).abs().max())
            if difference > AGREEMENT:
                raise SystemExit(f"{run.__name__}: the maxima or their gradients differ by {difference:.1e}")
    return {run.__name__: 1e3 * best_time(partial(both_ways, run), repeats) for run in (ours, bags, gathered)}


def tell(what: str, times: dict[str, float], peer: str) -> None:
    """A line to read, and one for programs."""
    print(f"{what}: " + ", ".join(f"{name} {milliseconds:.1f} ms" for name, milliseconds in times.items()))
    ours, other = times["ours"], times[peer]
    print(json.dumps({"claim": f"{what} by {peer}, ms", "ours": ours, "peer": other, "ratio": other / ours}))


def main() -> None:
    """Compares and times both sizes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="a few repeats")
    repeats = 3 if parser.parse_args().quick else 20
    torch.set_num_threads(1)
    for batch, size, count in SIZES:
        clouds = f"in {batch} clouds of {size} points"
        tell(f"{count} neighbours {clouds}", compare(batch, size, count, repeats), "topk")
        maxima = compare_maxima(batch, size, count, repeats)
        tell(f"maxima of {WIDTH} features over {count} neighbours {clouds}", maxima, "bags")


if __name__ == "__main__":
    main()
