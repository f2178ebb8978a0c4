"""From prepared shapes to batches for the ranking network.

A shape gives two *views*: its bodies (*parts given*) and the nodes of its hierarchy (*hierarchy given*). In either, a unit that
moves is one whose carrier has a joint and whose surroundings do not move with it; everything else rests.
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from kinmo.core.joint import Joint
from kinmo.features.candidate_features import Evidence
from kinmo.methods.kinmo.ranking.ranking_network import WORD_BUCKETS, RankingBatch

ANGLE_SCALE = np.radians(2.0)
LINE_SCALE = 0.015
"""Errors (radians, diagonals) that cost a hypothesis a factor e in the target."""
NEGLIGIBLE = 4.0
"""Hypotheses worse than the best by more than this many units of cost are wrong altogether."""


def hypothesis_costs(evidence: Evidence, rows: slice, joint: Joint, center: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cost [h] of taking each hypothesis for `joint`: angle and line error in their scales; infinite for another kind.

    The line error is the distance of the true axis, where it passes the part's `center`, from the hypothesis' line.
    """
    directions, pivots = evidence.directions[rows], evidence.pivots[rows]
    cost = np.arccos(np.clip(np.abs(directions @ joint.direction), 0.0, 1.0)) / ANGLE_SCALE
    if joint.has_pivot:
        at_part = joint.pivot + ((center - joint.pivot) @ joint.direction) * joint.direction
        offset = at_part - pivots
        offset -= np.sum(offset * directions, axis=1, keepdims=True) * directions
        cost = cost + np.linalg.norm(offset, axis=1) / LINE_SCALE
    return np.where(evidence.kinds[rows] == joint.kind.code, cost, np.inf)


def soft_target(costs: NDArray[np.float64]) -> NDArray[np.float64]:
    """Probability [h] of each hypothesis: one for the best alone, shared with those about as good."""
    relative = costs - costs.min()
    target = np.where(relative < NEGLIGIBLE, np.exp(-np.minimum(relative, NEGLIGIBLE)), 0.0)
    result: NDArray[np.float64] = target / target.sum()
    return result


def hash_words(kind: str, text: str) -> list[int]:
    """Buckets of the words of a name; `kind` keeps words of different roles apart."""
    return [zlib.crc32(f"{kind}:{word}".encode()) % WORD_BUCKETS for word in re.findall(r"[a-z]+", text.lower())]


@dataclass(frozen=True, eq=False)
class View:
    """The units of one shape that compete together, with their targets where the shape is annotated.

    `units` are indices into `evidence`'s units; `words[i]` the hashed names of unit i; `targets[i]` [h] or None for a unit at
    rest; `category` the hashed name of the shape's category, which goes for every unit.
    """

    shape_id: str
    evidence: Evidence
    units: tuple[int, ...]
    is_bodies: bool
    words: tuple[tuple[int, ...], ...]
    targets: tuple[NDArray[np.float64] | None, ...]
    category: tuple[int, ...] = ()
    weight: float = 1.0


def collate(
    views: Sequence[View],
    *,
    rng: np.random.Generator | None = None,
    hide_names: bool = False,
    hide_view: float = 0.0,
    hide_unit: float = 0.0,
    hide_category: float = 0.0,
) -> RankingBatch:
    """One flat batch of several views.

    With `rng`, the names of a view are hidden with probability `hide_view`, those of a unit with probability `hide_unit`, and a
    view's category with probability `hide_category`; with a probability of 1 it is hidden without `rng` too.
    """
    hypotheses: list[NDArray[np.float32]] = []
    units: list[NDArray[np.float32]] = []
    targets: list[NDArray[np.float64]] = []
    unit_of: list[NDArray[np.int64]] = []
    rest: list[float] = []
    weights: list[float] = []
    view_of: list[int] = []
    slot_of: list[int] = []
    words: list[int] = []
    word_unit: list[int] = []
    for number, view in enumerate(views):
        hidden = hide_names or (rng is not None and rng.random() < hide_view)
        unclassed = hide_category >= 1.0 or (hide_category > 0.0 and rng is not None and rng.random() < hide_category)
        for slot, (unit, names, target) in enumerate(zip(view.units, view.words, view.targets, strict=True)):
            rows = view.evidence.rows(unit)
            count = rows.stop - rows.start
            index = len(units)
            hypotheses.append(view.evidence.features[rows])
            units.append(np.append(view.evidence.unit_features[unit], np.float32(view.is_bodies)))
            targets.append(np.zeros(count) if target is None else target)
            rest.append(float(target is None))
            weights.append(view.weight)
            unit_of.append(np.full(count, index))
            view_of.append(number)
            slot_of.append(slot)
            if not hidden and not (rng is not None and rng.random() < hide_unit):
                shown = names if unclassed else names + view.category
                words.extend(shown)
                word_unit.extend([index] * len(shown))
    return RankingBatch(
        torch.from_numpy(np.concatenate(hypotheses)),
        torch.from_numpy(np.array(units, np.float32)),
        torch.from_numpy(np.concatenate(unit_of)),
        torch.tensor(view_of),
        torch.tensor(slot_of),
        torch.tensor(words, dtype=torch.long),
        torch.tensor(word_unit, dtype=torch.long),
        torch.from_numpy(np.concatenate(targets).astype(np.float32)),
        torch.tensor(rest, dtype=torch.float32),
        torch.tensor(weights, dtype=torch.float32),
    )
