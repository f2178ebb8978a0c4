"""Accuracy of joint limits on real objects with the true axes given, compared with limits from the sweep alone.

The range IoU (docs/background/metrics.md) is over all true joints with limits. `side` is the share of one-sided ranges with
their greater part on the true side. Real objects are needed (--data).

Usage:
    python bench/limits.py [--data DIR] [--cache DIR] [--quick]
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from common import CACHE, REAL_OBJECTS, has_real_objects, option_parser, print_claims, print_table
from kinmo import _core
from kinmo.core.joint import Joint, JointKind
from kinmo.dataset.folder_preparation import prepare_folder
from kinmo.dataset.store import PreparedStore
from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.metrics import limits, range_iou
from kinmo.features.candidate_joints import CandidateJoints
from kinmo.features.joint_limits import estimate_joint_limits
from kinmo.features.prepared_shape import PreparedShape, leaf_meshes
from kinmo.io.discover import ShapeSource

QUICK = 30
SMALL_SLIDER = 0.15
"""Small sliders are below this size, in diagonals."""
Guess = tuple[str, Joint, float, float]
"""Group, true joint, and the predicted range (lower, upper)."""


def guesses(shape: PreparedShape) -> Iterator[tuple[Guess, Guess]]:
    """The ranges of kinmo and of the sweep alone, for every limited joint of a shape."""
    meshes = leaf_meshes(ShapeSource.of(shape).read(), shape)
    assert shape.mobility is not None
    for index, body in shape.mobility.movable():
        joint, own = body.joint, list(shape.body_leaves[index])
        moving = sorted({leaf for below in shape.mobility.descendants(index) for leaf in shape.body_leaves[below]})
        rest = sorted(set(range(len(shape.leaves))) - set(moving))
        if joint is None or limits(joint) is None or not own or not rest:
            continue
        points = shape.leaf_points[own].reshape(-1, 3).astype(float)
        alone = CandidateJoints.of([joint], ["truth"])
        guessed = estimate_joint_limits(meshes, moving, rest, alone, points)
        turns = joint.kind is JointKind.REVOLUTE
        reach = np.array([math.pi / 2 if turns else max(float(np.ptp(points @ joint.direction)), 1e-6)])
        kind = np.array([0 if turns else 1], np.uint8)
        low, high, _ = _core.sweep(meshes, moving, rest, kind, alone.directions, alone.pivots, -reach, reach)
        name = (
            "hinges"
            if turns
            else "sliders, small"
            if np.linalg.norm(np.ptp(points, axis=0)) < SMALL_SLIDER
            else "sliders, large"
        )
        yield (name, joint, float(guessed.lower[0]), float(guessed.upper[0])), (name, joint, float(low[0]), float(high[0]))


def figures(found: list[Guess]) -> tuple[float, float]:
    """Mean range IoU, and share of ranges on the right side."""
    ious = [range_iou(joint, replace(joint, lower=low, upper=high)) or 0.0 for _, joint, low, high in found]
    sides = [
        np.sign(low + high) == np.sign(joint.lower + joint.upper)
        for _, joint, low, high in found
        if joint.lower is not None and joint.upper is not None and joint.lower * joint.upper == 0.0
    ]
    return float(np.mean(ious)), float(np.mean(sides)) if sides else math.nan


def main() -> int:
    """Print a line for each group, and the claim last."""
    parser = option_parser(__doc__, f"the first {QUICK} objects only")
    parser.add_argument("--data", type=Path, default=REAL_OBJECTS, help="folder of the real objects")
    parser.add_argument("--cache", type=Path, default=CACHE / "limits", help="folder of the prepared shapes")
    args = parser.parse_args()
    line = {"claim": "range IoU of joint limits, axes given", "ours": None, "peer": None, "ratio": None, "goal": 1.0}
    if not has_real_objects(args.data):
        print_claims({**line, "met": None})
        return 0
    prepare_folder(args.data, Workspace(args.cache))
    store = PreparedStore(Workspace(args.cache).prepared)
    entries = [entry for entry in store.entries if entry.joint_count][: QUICK if args.quick else None]
    pairs = [pair for entry in entries for pair in guesses(store.load(entry))]
    rows = []
    for group in (*sorted({ours[0] for ours, _ in pairs}), "all"):
        chosen = [pair for pair in pairs if group in (pair[0][0], "all")]
        (iou, side), (other, other_side) = (figures([pair[which] for pair in chosen]) for which in (0, 1))
        rows.append((group, len(chosen), iou, side, other, other_side))
    print_table(("", "joints", "kinmo: IoU", "side", "sweep: IoU", "side"), rows)
    print_claims({**line, "ours": iou, "peer": other, "ratio": iou / other, "met": iou > other})
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
