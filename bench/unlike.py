"""Which moving parts of real objects are unlike all procedural parts? What the generator lacks, in numbers.

    python bench/unlike.py [--data DIR] [--cache DIR] [--count 60] [--parts 20]

The numbers are those that describe a part as a whole (`kinmo.features.part_features`). A part is unlike where a number lies outside the
range of the moving parts of the procedural shapes of its category, but for their outermost percent; how far, in spreads of
these. What training never showed is what a network gets wrong: look at the parts at the top first. Shares data and cache with
`bench/real_objects.py`.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.features.candidate_features import Evidence, see_units
from kinmo.features.part_features import unit_numbers
from kinmo.features.prepared_shape import PreparedShape, leaf_meshes
from kinmo.io.readers import Found, Layout, read_found
from kinmo.methods.kinmo.ranked_mobility import scene_of
from kinmo.methods.kinmo.ranking.shape_views import body_view
from real_shapes import gathered, parser_for

OUTERMOST = 0.01
LEAST_SPREAD = 0.02
"""Smaller spreads are taken for this: of what never varies, all is far."""


@dataclass(frozen=True, eq=False)
class Part:
    """A moving part: its category, what to call it, and its numbers [G]."""

    category: str
    name: str
    numbers: NDArray[np.float64]


def moving_parts(shapes: Sequence[PreparedShape]) -> list[Part]:
    """The moving bodies of annotated shapes."""
    found = []
    for shape in shapes:
        assert shape.mobility is not None
        evidence = Evidence.of(shape.evidence)
        for body, unit in zip(shape.mobility.bodies, body_view(shape, evidence).units, strict=True):
            if body.joint is not None:
                numbers = evidence.unit_features[unit].astype(float)
                found.append(Part(shape.category, f"{shape.id} {body.name}", numbers))
    return found


def names_of_numbers(shape: PreparedShape) -> list[str]:
    """What the numbers of a part are called, taken from any shape."""
    meshes = leaf_meshes(read_found(Found(Path(shape.source), Layout(shape.layout), shape.id)), shape)
    scene = scene_of(shape, meshes)
    units = see_units(scene, [[0]])
    numbers = unit_numbers(scene, units[0], units[0].minimum.half_extents[None])
    return [
        f"{name} {place + 1}" if len(values) > 1 else name for name, values in numbers.items() for place in range(len(values))
    ]


@dataclass(frozen=True, eq=False)
class Range:
    """Where all parts but the outermost have their numbers [G], and how these spread."""

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    spread: NDArray[np.float64]

    @classmethod
    def of(cls, numbers: NDArray[np.float64]) -> Range:
        """The range of parts [n, G]."""
        low, high = np.quantile(numbers, [0.5 * OUTERMOST, 1.0 - 0.5 * OUTERMOST], axis=0)
        return cls(low, high, np.maximum(numbers.std(axis=0), LEAST_SPREAD))

    def excess(self, numbers: NDArray[np.float64]) -> NDArray[np.float64]:
        """How far [G] a part is outside, in spreads; 0 inside."""
        outside: NDArray[np.float64] = np.maximum(self.low - numbers, numbers - self.high) / self.spread
        return np.maximum(outside, 0.0)


def main() -> int:
    """Print the numbers by the share of parts that are outside, the parts that are farthest outside, and the claim."""
    parser = parser_for(__doc__, count=60)
    parser.add_argument("--parts", type=int, default=20, help="how many parts to name")
    parser.add_argument("--quick", action="store_true", help="6 procedural shapes a family")
    args = parser.parse_args()
    shapes = gathered(args.data, args.cache, 6 if args.quick else args.count, args.folds)
    outside = None
    if shapes is not None:
        outside = report(moving_parts(shapes.real), moving_parts(shapes.procedural), shapes.real[0], args.parts)
    claim = "share of the numbers of real parts outside the range of procedural ones of their category"
    print(json.dumps({"claim": claim, "ours": outside, "peer": None, "ratio": None, "goal": None, "met": None}))
    return 0


def report(real: Sequence[Part], procedural: Sequence[Part], any_shape: PreparedShape, count: int) -> float:
    """Print both tables; the share of all numbers that are outside."""
    by_category: dict[str, list[NDArray[np.float64]]] = defaultdict(list)
    for part in procedural:
        by_category[part.category].append(part.numbers)
    ranges = {category: Range.of(np.array(numbers)) for category, numbers in by_category.items()}
    known = [part for part in real if part.category in ranges]
    names = names_of_numbers(any_shape)
    distances = np.array([ranges[part.category].excess(part.numbers) for part in known])
    print(f"{len(known)} of {len(real)} real parts are of a category that is generated, of {len(procedural)} procedural parts")
    shares = (distances > 0).mean(axis=0)
    for index in np.argsort(-shares, kind="stable")[:12]:
        print(f"{names[index]:32s} outside for {shares[index]:6.1%} of the parts")
    for place in np.argsort(-distances.max(axis=1), kind="stable")[:count]:
        worst = np.argsort(-distances[place], kind="stable")[:3]
        said = ", ".join(f"{names[index]} by {distances[place, index]:.1f}" for index in worst if distances[place, index] > 0)
        print(f"{known[place].category} {known[place].name}: {said}")
    return float((distances > 0).mean())


if __name__ == "__main__":
    raise SystemExit(main())
