"""Merge tree of a shape's leaves: the most certain pairs are joined first (average linkage on a signed graph).

Its nodes are candidate bodies. A body is found if its leaves are joined with each other before one of them is joined with
another body.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Merge:
    """A node of the merge tree.

    Attributes:
        leaves: Positions of its leaves, ascending.
        logit: Mean logit, over the pairs between its two halves, that both belong to one body.
        halves: The two sets of leaves that it joins.
    """

    leaves: tuple[int, ...]
    logit: float
    halves: tuple[tuple[int, ...], tuple[int, ...]]


def merge_leaves(count: int, pairs: NDArray[np.int64], logits: NDArray[np.float64]) -> list[Merge]:
    """Join clusters of leaves, those with the highest mean logit between them first.

    Args:
        count: Number of leaves.
        pairs: [P, 2] pairs of leaves, each once.
        logits: [P] logits that a pair belongs to one body.

    Returns:
        The merges in their order. Clusters without a pair between them are not joined.
    """
    clusters: dict[int, tuple[int, ...]] = {leaf: (leaf,) for leaf in range(count)}
    links: dict[int, dict[int, tuple[float, int]]] = {leaf: {} for leaf in range(count)}
    for (first, second), logit in zip(pairs.tolist(), logits.tolist(), strict=True):
        links[first][second] = links[second][first] = logit, 1
    queue = [(-logit, min(pair), max(pair)) for pair, logit in zip(pairs.tolist(), logits.tolist(), strict=True)]
    heapq.heapify(queue)
    merges: list[Merge] = []
    while queue:
        cost, first, second = heapq.heappop(queue)
        if first not in clusters or second not in clusters:
            continue
        joined = count + len(merges)
        halves = clusters.pop(first), clusters.pop(second)
        around: dict[int, tuple[float, int]] = {}
        for half in (first, second):
            for other, (total, number) in links.pop(half).items():
                if other in clusters:
                    known_total, known_number = around.get(other, (0.0, 0))
                    around[other] = known_total + total, known_number + number
        clusters[joined], links[joined] = tuple(sorted(halves[0] + halves[1])), around
        for other, link in around.items():
            links[other][joined] = link
            heapq.heappush(queue, (-link[0] / link[1], other, joined))
        merges.append(Merge(clusters[joined], -cost, halves))
    return merges
