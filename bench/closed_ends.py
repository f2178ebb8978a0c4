"""How far from the truth pseudo labels have the closed ends of joints: as their limits say, and as `likely_closed` has it.

Of pseudo labels beside labels that were held back, or of true axes of real objects, without their limits:

    python bench/closed_ends.py WORKSPACE --category dishwasher
    python bench/closed_ends.py --real data/partnet
"""

from __future__ import annotations

import argparse
import json
import math
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from kinmo.formats import Found, Layout, discover, read_found
from kinmo.joint import Joint, JointKind
from kinmo.limits import MOST_TURN
from kinmo.mobility import Mobility
from kinmo.pipeline.dataset import open_dataset
from kinmo.pipeline.label_decisions import folder_name
from kinmo.scans.articulated_object import ArticulatedObject, articulated_object
from kinmo.scans.closing import closed
from kinmo.scans.likely_closed import likely_closed
from kinmo.shape import Shape
from kinmo.workspace import Workspace

FAR = {JointKind.REVOLUTE: 5.0, JointKind.PRISMATIC: 0.05}
"""Degrees, and diagonals, from which on a closed end is wrong."""


def main() -> None:
    """Print a line for every kind of joint and way."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("workspace", type=Path, nargs="?")
    parser.add_argument("--category", default="refrigerator")
    parser.add_argument("--real", type=Path)
    arguments = parser.parse_args()
    if arguments.real is not None:
        tell(real(arguments.real))
    elif arguments.workspace is not None:
        tell(pseudo(Workspace(arguments.workspace), arguments.category))
    else:
        parser.error("a workspace, or --real")


def pseudo(workspace: Workspace, category: str) -> Iterator[tuple[str, JointKind, float]]:
    """Errors of the joints of objects whose labels have the structure of the truth."""
    dataset = open_dataset(workspace, category)
    hidden = {entry.id: entry for entry in dataset.hidden}
    for entry in dataset.unlabelled:
        folder, original = workspace.pseudo / folder_name(entry), dataset.truths.get((entry.id, entry.layout))
        if original is None or not (folder / "mobility_v2.json").exists():
            continue
        truth = hidden[original]
        said, true = (
            as_in_file(read_found(found))
            for found in (
                Found(folder, Layout.PARTNET_MOBILITY, entry.id),
                Found(Path(truth.source), Layout(truth.layout), truth.id),
            )
        )
        if said is None or true is None or said.structure != true.structure:
            continue
        right = opened(true, true.mobility)
        for way, mobility in ways(said, said.mobility):
            for leaves, (joint, value) in opened(said, mobility).items():
                if leaves in right:
                    yield way, joint.kind, value - right[leaves][1]


def real(folder: Path) -> Iterator[tuple[str, JointKind, float]]:
    """Errors of the limited hinges of objects, of which a quarter of a turn to either side is all that is said."""
    for found in discover(folder):
        true = as_in_file(read_found(found))
        if true is None:
            continue
        right = opened(true, true.mobility)
        bodies = [replace(body, joint=body.joint and nothing_said(body.joint)) for body in true.mobility.bodies]
        free = Mobility(tuple(bodies))
        said = {body.leaves: body.joint for body in free.bodies}
        for way, mobility in ways(true, free):
            for leaves, (joint, value) in opened(true, mobility).items():
                if joint.kind is JointKind.REVOLUTE and leaves in right and right[leaves][0].is_limited:
                    yield way, joint.kind, value - right[leaves][1]
                    if joint is not said[leaves]:
                        yield "likely, of what can lie straight", joint.kind, value - right[leaves][1]


def as_in_file(shape: Shape) -> ArticulatedObject | None:
    """The parts in the state of the file; None for what has none that are large enough."""
    try:
        return articulated_object(shape, closes=False)
    except ValueError:
        return None


def nothing_said(joint: Joint) -> Joint:
    return replace(joint, lower=joint.rest - MOST_TURN, upper=joint.rest + MOST_TURN)


def ways(target: ArticulatedObject, mobility: Mobility) -> Iterator[tuple[str, Mobility]]:
    yield "limits", mobility
    yield "likely", likely_closed(mobility, target.meshes, MOST_TURN)


def opened(target: ArticulatedObject, mobility: Mobility) -> dict[tuple[int, ...], tuple[Joint, float]]:
    """The joints, and how far open the file shows each (degrees, or diagonals), by the leaves that they move."""
    found = {}
    ends, _ = closed(mobility, target.meshes)
    for index, body in mobility.movable():
        before, after = body.joint, ends.bodies[index].joint
        if before is not None and after is not None and after.lower is not None:
            rest = before.rest if after.lower == before.lower else -before.rest  # else the direction was turned round
            value = rest - after.lower
            found[body.leaves] = before, math.degrees(value) if before.kind is JointKind.REVOLUTE else value
    return found


def tell(errors: Iterator[tuple[str, JointKind, float]]) -> None:
    by_way: dict[tuple[JointKind, str], list[float]] = defaultdict(list)
    for way, kind, error in errors:
        by_way[kind, way].append(abs(error))
    for (kind, way), found in sorted(by_way.items(), key=str):
        if kind in FAR:
            far = np.mean(np.array(found) > FAR[kind])
            print(f"{kind.value}, by {way}: {len(found)} joints, {np.mean(found):.4g} off, {far:.1%} far")
    for kind in FAR:
        limits, likely = (by_way.get((kind, way)) for way in ("limits", "likely"))
        if limits and likely:
            before, after = float(np.mean(limits)), float(np.mean(likely))
            claim = f"how far off closed ends of {kind.value} are by what is likely, beside by limits (degrees, or diagonals)"
            ratio = before / max(after, 1e-12)
            print(
                json.dumps({"claim": claim, "ours": after, "peer": before, "ratio": ratio, "goal": 1.0, "met": after <= before})
            )


if __name__ == "__main__":
    main()
