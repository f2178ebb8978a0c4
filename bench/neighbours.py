"""Nearest points and maxima over them as in the networks, compared with torch and SciPy, one thread.

The nearest neighbours of every point of point clouds are compared with torch's topk and SciPy's search tree. The maxima of 64
features over the neighbours, with their gradients, are compared with torch's embedding bags and with gathering. The sizes are
those of axis selection: 64 clouds of 256 points with 8 neighbours (`small`), 16 of 1,024 with 20 (`paper`). All must find
equally near points, and equal maxima and gradients.

Usage:
    python bench/neighbours.py [--quick]
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from common import Claim, best_time, option_parser, print_claims, print_table, ratio_claim, use_one_thread

use_one_thread()

import numpy as np
import torch
from scipy.spatial import cKDTree

from kinmo import _core
from kinmo.learning.network_layers import gather_points, neighbour_max

SIZES = ((64, 256, 8), (16, 1024, 20))
"""Clouds, points a cloud and neighbours a point."""
WIDTH = 64
"""Number of features."""
AGREEMENT = 1e-5


def neighbour_times(batch: int, size: int, count: int, repeats: int) -> dict[str, float]:
    """Times in ms of finding the neighbours, by name, after a check that all agree."""
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


def maxima_times(batch: int, size: int, count: int, repeats: int) -> dict[str, float]:
    """Times in ms of the maxima of `WIDTH` features and their gradients, by name, after a check that all agree."""
    torch.manual_seed(0)
    distinct = torch.randperm(batch * size * WIDTH).float()  # each method gives the gradient of ties to another point
    features, slopes = distinct.view(batch, size, WIDTH).requires_grad_(), torch.randn(batch, size, WIDTH)
    index = torch.from_numpy(_core.nearest_neighbours(torch.rand(batch, size, 3).numpy(), count))
    rows = (index + torch.arange(batch).view(-1, 1, 1) * size).flatten(0, 1)

    def ours() -> torch.Tensor:
        return neighbour_max(features, index)

    def bags() -> torch.Tensor:
        return torch.nn.functional.embedding_bag(rows, features.flatten(0, 1), mode="max").view_as(features)

    def gathering() -> torch.Tensor:
        return gather_points(features, index).amax(2)

    def both_ways(maxima: Callable[[], torch.Tensor]) -> tuple[torch.Tensor, torch.Tensor]:
        found = maxima()
        return found.detach(), torch.autograd.grad(found, features, slopes)[0]

    expected = both_ways(gathering)
    for run in (ours, bags):
        for found, wanted in zip(both_ways(run), expected, strict=True):
            difference = float((found - wanted).abs().max())
            if difference > AGREEMENT:
                raise SystemExit(f"{run.__name__}: the maxima or their gradients differ by {difference:.1e}")
    return {run.__name__: 1e3 * best_time(partial(both_ways, run), repeats) for run in (ours, bags, gathering)}


def main() -> None:
    """Compare and time both sizes."""
    repeats = 3 if option_parser(__doc__, "few repeats").parse_args().quick else 20
    torch.set_num_threads(1)
    claims: list[Claim] = []
    rows: list[tuple[str, str, float, float]] = []
    for batch, size, count in SIZES:
        clouds = f"{batch} clouds of {size} points"
        for what, times in (
            (f"{count} neighbours in {clouds}", neighbour_times(batch, size, count, repeats)),
            (f"maxima of {WIDTH} features over {count} neighbours in {clouds}", maxima_times(batch, size, count, repeats)),
        ):
            ours, *peers = times.items()
            rows += [(what, name, time, time / ours[1]) for name, time in times.items()]
            claims.append(
                ratio_claim(f"{what} compared with torch ({peers[0][0]}), ms", ours=ours[1], peer=peers[0][1], goal=None)
            )
    print_table(("task", "method", "time (ms)", "ratio"), rows)
    print_claims(*claims)


if __name__ == "__main__":
    main()
