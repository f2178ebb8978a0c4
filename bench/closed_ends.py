"""How far from the truth pseudo labels have the closed ends of joints: as their limits say, and as `likely_closed` has it.

Of pseudo labels beside labels that were held back, or of true axes of real objects, without their limits:

    python bench/closed_ends.py WORKSPACE --category dishwasher
    python bench/closed_ends.py --real data/partnet
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections import defaultdict
from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body, Mobility
from kinmo.core.shape import Shape
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.workspace import Workspace
from kinmo.features.free_travel import MOST_TURN
from kinmo.io.readers import Found, Layout, discover, read_found
from kinmo.pipeline.label_decisions import folder_name
from kinmo.scans.articulated_object import ArticulatedObject, articulated_object

F64 = NDArray[np.float64]
Error = tuple[str, JointKind, float]
"""A way to tell where joints are closed, and how far from there a joint of a kind is by it."""

FAR = {JointKind.REVOLUTE: 5.0, JointKind.PRISMATIC: 0.05}
"""Degrees, and diagonals, from which on a closed end is wrong."""
LEAST_POINTS = 8
"""Fewer may fit a rigid motion by chance."""

FEW = 40


def main() -> None:
    """Print a line for every kind of joint and way."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("workspace", type=Path, nargs="?")
    parser.add_argument("--category", default="refrigerator")
    parser.add_argument("--real", type=Path)
    parser.add_argument("--quick", action="store_true", help=f"of {FEW} joints")
    arguments = parser.parse_args()
    most = FEW if arguments.quick else None
    if arguments.real is not None:
        tell(islice(real(arguments.real), most))
    elif arguments.workspace is not None:
        tell(islice(pseudo(Workspace(arguments.workspace), arguments.category), most))
    else:
        parser.error("a workspace, or --real")


def pseudo(workspace: Workspace, category: str) -> Iterator[Error]:
    """Errors of the joints of objects whose labels have the structure of the truth."""
    dataset = open_dataset(workspace, category)
    hidden = {entry.id: entry for entry in dataset.hidden}
    for entry in dataset.unlabelled:
        folder, original = workspace.pseudo / folder_name(entry), dataset.truths.get((entry.id, entry.layout))
        if original is None or not (folder / "mobility_v2.json").exists():
            continue
        entry_of_truth = hidden[original]
        said = read_found(Found(folder, Layout.PARTNET_MOBILITY, entry.id))
        true = read_found(Found(Path(entry_of_truth.source), Layout(entry_of_truth.layout), entry_of_truth.id))
        right = Closed.of(true)
        ways = {"limits": Closed.of(said), "likely": Closed.of(said, guessed_within=MOST_TURN)}
        for way, found in ways.items():
            if found is not None and right is not None and found.shown.structure == right.shown.structure:
                yield from ((way, joint.kind, error) for joint, error in known_errors(entry.id, found, right))


def real(folder: Path) -> Iterator[Error]:
    """Errors of the limited hinges of objects, of which a quarter of a turn to either side is all that is said."""
    for source in discover(folder):
        true = read_found(source)
        right = Closed.of(true)
        if right is None or true.mobility is None:
            continue
        bodies = [replace(body, joint=body.joint and nothing_said(body.joint)) for body in true.mobility.bodies]
        free = Mobility(tuple(bodies))
        ways = {"limits": Closed.of(true, free), "likely": Closed.of(true, free, MOST_TURN)}
        limited = {body.leaves for body in right.shown.mobility.bodies if body.joint is not None and body.joint.is_limited}
        for way, found in ways.items():
            for joint, error in known_errors(source.id, found, right, limited) if found is not None else ():
                if joint.kind is JointKind.REVOLUTE:
                    yield way, joint.kind, error


def nothing_said(joint: Joint) -> Joint:
    return replace(joint, lower=joint.rest - MOST_TURN, upper=joint.rest + MOST_TURN)


class OtherPoints(ValueError):
    """The parts of the canonical state are not those that the file shows."""


def known_errors(
    name: str, found: Closed, right: Closed, those: Container[tuple[int, ...]] | None = None
) -> list[tuple[Joint, float]]:
    """`found.errors`; none where they cannot be told, which is said."""
    try:
        return list(found.errors(right, those))
    except OtherPoints:
        print(f"{name} left out: its parts are others when it is closed", file=sys.stderr)
        return []


@dataclass(frozen=True)
class Closed:
    """An object as its file shows it, and its canonical state, as it is scanned in."""

    shown: ArticulatedObject
    canonical: ArticulatedObject

    @classmethod
    def of(cls, shape: Shape, mobility: Mobility | None = None, guessed_within: float | None = None) -> Closed | None:
        """None for what has no parts that are large enough."""
        try:
            shown = articulated_object(shape, mobility, closes=False)
            return cls(shown, articulated_object(shape, mobility, guessed_within=guessed_within))
        except ValueError:
            return None

    def errors(self, right: Closed, those: Container[tuple[int, ...]] | None = None) -> Iterator[tuple[Joint, float]]:
        """Of every joint, or of the bodies with `those` leaves: how far its part is from where it is closed by what is right.

        In degrees for hinges, else in diagonals, seen from what it hangs by.
        """
        bodies, theirs = self.shown.mobility.bodies, right.shown.mobility.bodies
        mine, true = self._poses(), right._poses()
        for index, body in self.shown.mobility.movable():
            if body.joint is None or (those is not None and body.leaves not in those):
                continue
            parent = body.parent or 0
            said, wanted = (
                np.linalg.inv(poses[of[parent]]) @ poses[of[index]]
                for poses, of in ((mine, range(len(bodies))), (true, alike(bodies, theirs)))
            )
            corners = self.shown.meshes[index].vertices
            middle = np.append(0.5 * (corners.min(axis=0) + corners.max(axis=0)), 1.0)
            turned = Rotation.from_matrix(said[:3, :3].T @ wanted[:3, :3]).magnitude()
            is_hinge = body.joint.kind is JointKind.REVOLUTE
            yield body.joint, math.degrees(turned) if is_hinge else float(np.linalg.norm((said - wanted) @ middle))

    def _poses(self) -> list[F64]:
        """What takes the parts from the file to the canonical state, [4, 4] each, its scale left out."""
        places = alike(self.shown.mobility.bodies, self.canonical.mobility.bodies)
        return [
            moved(mesh.vertices, self.canonical.meshes[place].vertices)
            for mesh, place in zip(self.shown.meshes, places, strict=True)
        ]


def alike(those: Sequence[Body], others: Sequence[Body]) -> list[int]:
    """For each of some bodies that one of the others with which it has most leaves in common: a pin may go with either half."""
    return [max(range(len(others)), key=lambda i: len({*body.leaves} & {*others[i].leaves})) for body in those]


def moved(before: F64, after: F64) -> F64:
    """The rigid motion [4, 4] that takes points [n, 3] to where they are after it, but for a scale.

    Told by as many of the last ones as move as one: a pin's come first, and may go another way, or with another part.
    """
    common = min(len(before), len(after))
    least = max(common // 16, min(common, LEAST_POINTS) - 1)
    for count in range(common, least, -max(common // 16, 1)):
        pose, residual = fitted(before[-count:], after[-count:])
        if residual < 1e-6:
            return pose
    raise OtherPoints


def fitted(before: F64, after: F64) -> tuple[F64, float]:
    """The rigid motion [4, 4] that takes points [n, 3] nearest to others, at another scale, and how far they are from there."""
    middles = before.mean(axis=0), after.mean(axis=0)
    from_middle, to_middle = before - middles[0], after - middles[1]
    scale = np.linalg.norm(to_middle) / np.linalg.norm(from_middle)
    left, _, right = np.linalg.svd(to_middle.T @ from_middle)
    pose = np.eye(4)
    pose[:3, :3] = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    pose[:3, 3] = middles[1] / scale - pose[:3, :3] @ middles[0]
    return pose, float(np.abs(from_middle @ pose[:3, :3].T - to_middle / scale).max())


def tell(errors: Iterator[Error]) -> None:
    by_way: dict[tuple[JointKind, str], list[float]] = defaultdict(list)
    for way, kind, error in errors:
        by_way[kind, way].append(error)
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
