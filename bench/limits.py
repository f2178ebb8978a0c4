"""How well are the limits of joints guessed, their axes given? Real objects, beside limits from the sweep alone.

    python bench/limits.py [--data DIR] [--cache DIR] [--quick]

The range IoU is that of docs/metrics.md, over all true joints with limits; `side` is the share of one-sided ranges whose
greater part is on the true side. Without real objects below --data nothing can be measured, and the script says so.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from kinmo import _core
from kinmo.core.joint import Joint, JointKind
from kinmo.dataset.folder_preparation import prepare_folder
from kinmo.dataset.store import PreparedStore
from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.metrics import limits, range_iou
from kinmo.features.candidate_joints import Candidates
from kinmo.features.free_travel import free_travel
from kinmo.features.prepared_shape import PreparedShape, leaf_meshes
from kinmo.io.readers import Found, Layout, read_found

ROOT = Path(__file__).parents[1]
QUICK = 30
Guess = tuple[str, Joint, float, float]
"""Group, true joint, and the range that is guessed."""


def guesses(shape: PreparedShape) -> Iterator[tuple[Guess, Guess]]:
    """For every limited joint of a shape what kinmo and what the sweep alone say."""
    meshes = leaf_meshes(read_found(Found(Path(shape.source), Layout(shape.layout), shape.id)), shape)
    assert shape.mobility is not None
    for index, body in shape.mobility.movable():
        joint, own = body.joint, list(shape.body_leaves[index])
        moving = sorted({leaf for below in shape.mobility.descendants(index) for leaf in shape.body_leaves[below]})
        rest = sorted(set(range(len(shape.leaves))) - set(moving))
        if joint is None or limits(joint) is None or not own or not rest:
            continue
        points = shape.leaf_points[own].reshape(-1, 3).astype(float)
        alone = Candidates(np.array([joint.kind.code], np.uint8), joint.direction[None], joint.pivot[None], ("truth",))
        guessed = free_travel(meshes, moving, rest, alone, points)
        turns = joint.kind is JointKind.REVOLUTE
        reach = np.array([math.pi / 2 if turns else max(float(np.ptp(points @ joint.direction)), 1e-6)])
        kind = np.array([0 if turns else 1], np.uint8)
        low, high, _ = _core.sweep(meshes, moving, rest, kind, alone.directions, alone.pivots, -reach, reach)
        name = "hinges" if turns else "sliders, small" if np.linalg.norm(np.ptp(points, axis=0)) < 0.15 else "sliders, large"
        yield (name, joint, float(guessed.lower[0]), float(guessed.upper[0])), (name, joint, float(low[0]), float(high[0]))


def figures(found: list[Guess]) -> tuple[float, float]:
    """Mean range IoU, and share of right sides."""
    ious = [range_iou(joint, replace(joint, lower=low, upper=high)) or 0.0 for _, joint, low, high in found]
    sides = [
        np.sign(low + high) == np.sign(joint.lower + joint.upper)
        for _, joint, low, high in found
        if joint.lower is not None and joint.upper is not None and joint.lower * joint.upper == 0.0
    ]
    return float(np.mean(ious)), float(np.mean(sides)) if sides else math.nan


def main() -> int:
    """Print a line a group, and the claim last."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=ROOT / "data" / "partnet" / "gensim2")
    parser.add_argument("--cache", type=Path, default=ROOT / "workspace" / "bench" / "limits")
    parser.add_argument("--quick", action="store_true", help=f"the first {QUICK} objects only")
    args = parser.parse_args()
    line = {"claim": "range IoU of joint limits, axes given", "ours": None, "peer": None, "ratio": None, "goal": 1.0}
    if not args.data.exists():
        print(f"no real objects at {args.data}: docs/getting-the-data.md says where they come from")
        print(json.dumps({**line, "met": None}))
        return 0
    prepare_folder(args.data, Workspace(args.cache))
    store = PreparedStore(Workspace(args.cache).prepared)
    entries = [entry for entry in store.entries if entry.joint_count][: QUICK if args.quick else None]
    pairs = [pair for entry in entries for pair in guesses(store.load(entry))]
    print(f"{'':16}{'joints':>8}{'kinmo: IoU':>12}{'side':>8}{'sweep: IoU':>12}{'side':>8}")
    for group in (*sorted({ours[0] for ours, _ in pairs}), "all"):
        chosen = [pair for pair in pairs if group in (pair[0][0], "all")]
        (iou, side), (other, other_side) = (figures([pair[which] for pair in chosen]) for which in (0, 1))
        print(f"{group:16}{len(chosen):>8}{iou:>12.3f}{side:>8.3f}{other:>12.3f}{other_side:>8.3f}")
    print(json.dumps({**line, "ours": iou, "peer": other, "ratio": iou / other, "met": iou > other}))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
