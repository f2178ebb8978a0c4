"""Accuracy of joint limits on real objects with the true axes given: learned, by rule, and from the sweep alone.

Learned limits are those of the networks of --model, by default the ones that come with kinmo, which never saw the objects. The
rule is that of the paper's method (docs/background/metrics.md, "Limits"). The range IoU is over all true joints with limits.
`side` is the share of one-sided ranges with their greater part on the true side. Real objects are needed (--data).

Usage:
    python bench/limits.py [--data DIR] [--cache DIR] [--model WORKSPACE] [--quick]
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from common import CACHE, REAL_OBJECTS, Cell, has_real_objects, option_parser, print_claims, print_table
from kinmo import _core
from kinmo.core.joint import Joint, JointKind
from kinmo.core.shape_estimate import JointEstimate
from kinmo.dataset.folder_preparation import prepare_folder
from kinmo.dataset.store import PreparedStore
from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.metrics import limits, range_iou
from kinmo.features.candidate_joints import CandidateJoints
from kinmo.features.joint_limits import estimate_joint_limits
from kinmo.features.prepared_shape import PreparedShape, leaf_meshes
from kinmo.features.shape_geometry import ShapeGeometry
from kinmo.io.discover import ShapeSource
from kinmo.learning.model_folder import SHIPPED, WEIGHTS, ModelFolder
from kinmo.methods.kinmo.body_ranking import features_of_groups
from kinmo.methods.kinmo.kinematic_tree import ShapeLimits
from kinmo.methods.kinmo.limits.limits_predictor import LimitsPredictor

QUICK = 30
SMALL_SLIDER = 0.15
"""Small sliders are below this size, in diagonals."""
LEARNED, RULE, SWEEP = "learned", "rule", "sweep"
Ranges = dict[str, Joint]
"""A joint with the ranges of all ways to find them, by name."""


def found_ranges(shape: PreparedShape, limiter: LimitsPredictor | None) -> Iterator[tuple[str, Joint, Ranges]]:
    """Group, true joint and found ranges of every limited joint of a shape. Without a network, there is no learned range."""
    meshes = leaf_meshes(ShapeSource.of(shape).read(), shape)
    bodies = [leaves for leaves in shape.body_leaves if leaves]
    learned: ShapeLimits | None = None
    if limiter is not None:
        geometry = ShapeGeometry.of_prepared(shape, meshes)
        learned = ShapeLimits(shape, geometry, features_of_groups(shape, geometry, bodies), limiter)
    assert shape.mobility is not None
    for index, body in shape.mobility.movable():
        joint, own = body.joint, shape.body_leaves[index]
        moving = sorted({leaf for below in shape.mobility.descendants(index) for leaf in shape.body_leaves[below]})
        rest = sorted(set(range(len(shape.leaves))) - set(moving))
        if joint is None or limits(joint) is None or not own or not rest:
            continue
        bare = replace(joint, lower=None, upper=None, rest=0.0)
        points = shape.leaf_points[list(own)].reshape(-1, 3).astype(float)
        alone = CandidateJoints.of([bare], ["truth"])
        lower, upper = estimate_joint_limits(meshes, moving, rest, alone, points).range(0)
        turns = joint.kind is JointKind.REVOLUTE
        reach = np.array([math.pi / 2 if turns else max(float(np.ptp(points @ joint.direction)), 1e-6)])
        kind = np.array([0 if turns else 1], np.uint8)
        low, high, _ = _core.sweep(meshes, moving, rest, kind, alone.directions, alone.pivots, -reach, reach)
        found = {
            RULE: replace(bare, lower=lower, upper=upper),
            SWEEP: replace(bare, lower=float(low[0]), upper=float(high[0])),
        }
        if learned is not None:
            (estimate,) = learned.added([JointEstimate(bare, shape.body_types[index], 1.0)], own, moving)
            assert estimate.joint is not None
            found[LEARNED] = estimate.joint
        is_small = np.linalg.norm(np.ptp(points, axis=0)) < SMALL_SLIDER
        yield "hinges" if turns else "sliders, small" if is_small else "sliders, large", joint, found


def figures(pairs: Sequence[tuple[Joint, Joint]]) -> tuple[float, float]:
    """Mean range IoU, and share of ranges on the right side, of pairs of true and found joints."""
    ious = [range_iou(true, found) or 0.0 for true, found in pairs]
    sides = [_side(found, true) == _side(true, true) for true, found in pairs if true.lower == 0.0 or true.upper == 0.0]
    return float(np.mean(ious)), float(np.mean(sides)) if sides else math.nan


def _side(joint: Joint, true: Joint) -> float:
    """Side of the true direction that the greater part of a range is on: 1 or -1; 0 for neither, and without a range."""
    lower, upper = joint.lower or 0.0, joint.upper or 0.0
    return float(np.sign(lower + upper) * np.sign(joint.direction @ true.direction))


def main() -> int:
    """Print a line for each group, and the claim last."""
    parser = option_parser(__doc__, f"the first {QUICK} objects only")
    parser.add_argument("--data", type=Path, default=REAL_OBJECTS, help="folder of the real objects")
    parser.add_argument("--cache", type=Path, default=CACHE / "limits", help="folder of the prepared shapes")
    parser.add_argument("--model", type=Path, default=SHIPPED, help="workspace of the networks (default: those of kinmo)")
    args = parser.parse_args()
    line = {"claim": "range IoU of joint limits, axes given", "ours": None, "peer": None, "ratio": None, "goal": 1.0}
    if not has_real_objects(args.data):
        print_claims({**line, "met": None})
        return 0
    weights = ModelFolder(Workspace(args.model).models).folder("limits") / WEIGHTS
    if not weights.exists():
        print(f"no learned limits: expected {weights} (kinmo train kinmo, or make weights)")
    limiter = LimitsPredictor.load(weights, "cpu") if weights.exists() else None
    prepare_folder(args.data, Workspace(args.cache))
    store = PreparedStore(Workspace(args.cache).prepared)
    entries = [entry for entry in store.entries if entry.joint_count][: QUICK if args.quick else None]
    ranges = [found for entry in entries for found in found_ranges(store.load(entry), limiter)]
    ways = (LEARNED, RULE, SWEEP) if limiter is not None else (RULE, SWEEP)
    rows: list[tuple[Cell, ...]] = []
    for group in (*sorted({name for name, _, _ in ranges}), "all"):
        chosen = [(true, found) for name, true, found in ranges if group in (name, "all")]
        results = {way: figures([(true, found[way]) for true, found in chosen]) for way in ways}
        rows.append((group, len(chosen), *(figure for way in ways for figure in results[way])))
    print_table(("", "joints", *(f"{way}: {title}" for way in ways for title in ("IoU", "side"))), rows)
    ours, peer = results[ways[0]][0], results[SWEEP][0]
    print_claims({**line, "ours": ours, "peer": peer, "ratio": ours / peer, "met": ours > peer})
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
