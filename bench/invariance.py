"""Share of joints that stay the same when a file changes in ways that must not matter.

Every GLB file of a folder is predicted as it is, and again

    renamed     under another file name
    reordered   with its nodes in another order
    nested      with each node in two empty groups
    turned      rotated about up by 90 degrees, with the new front stated

A joint is the same if the other prediction has a joint of the same kind on a body of the same area and middle, with its axis
within 1 degree and its line within 0.01 of the diagonal.

Usage:
    python bench/invariance.py FOLDER [--workspace DIR] [--limit N] [--quick]
"""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from common import option_parser, print_claims, print_table, use_one_thread

use_one_thread()
import numpy as np
from numpy.typing import NDArray

import kinmo
from kinmo.core.joint import Joint, JointKind

QUICK = 2
GOAL = 0.98
"""Least share of joints that stay the same."""
QUARTER_TURN = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
"""Rotation about y that turns the front from z to x."""
HEADER_SIZE, JSON_CHUNK = 20, 0x4E4F534A
Document = dict[str, Any]


def renamed(document: Document) -> None:
    """Change nothing: the new file has another name anyway."""


def reordered(document: Document) -> None:
    """Put the nodes, and the children of each, in another order."""
    nodes = document["nodes"]
    order = np.random.default_rng(0).permutation(len(nodes))
    place = {int(old): new for new, old in enumerate(order)}
    document["nodes"] = [nodes[old] for old in order]
    for holder in (*document["nodes"], *document["scenes"]):
        for key in {"children", "nodes"} & set(holder):
            holder[key] = sorted(place[child] for child in holder[key])


def nested(document: Document) -> None:
    """Put two groups without names around every node that has a mesh."""
    nodes = document["nodes"]
    for index in [index for index, node in enumerate(nodes) if "mesh" in node]:
        inner = len(nodes)
        nodes += [nodes[index], {"children": [inner]}]
        nodes[index] = {"children": [inner + 1]}


def turned(document: Document) -> None:
    """Turn the whole scene by 90 degrees about y."""
    scene = document["scenes"][document.get("scene", 0)]
    half = float(np.sqrt(0.5))
    document["nodes"].append({"children": scene["nodes"], "rotation": [0.0, half, 0.0, half]})
    scene["nodes"] = [len(document["nodes"]) - 1]


CHANGES: dict[str, Callable[[Document], None]] = {change.__name__: change for change in (renamed, reordered, nested, turned)}


def write_changed(source: Path, target: Path, change: Callable[[Document], None]) -> None:
    """Write a GLB file whose JSON was changed."""
    data = source.read_bytes()
    size, kind = (int(value) for value in np.frombuffer(data, "<u4", 2, offset=12))
    if kind != JSON_CHUNK:
        raise SystemExit(f"{source}: expected a GLB file")
    document = json.loads(data[HEADER_SIZE : HEADER_SIZE + size])
    change(document)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = data[HEADER_SIZE + size :]
    head = np.array([HEADER_SIZE + len(text) + len(rest), len(text), JSON_CHUNK], "<u4").tobytes()
    target.write_bytes(data[:8] + head + text + rest)


class MovingBody(NamedTuple):
    """A body that moves and its joint, in the frame of the unchanged file."""

    joint: Joint
    area: float
    middle: NDArray[np.float64]


def moving_bodies(prediction: kinmo.Prediction, turn: NDArray[np.float64]) -> list[MovingBody]:
    """The bodies of a prediction that move, turned back by the inverse of `turn` [3, 3]."""
    shape, found = prediction.shape, []
    for _, body in prediction.estimate.mobility.movable():
        meshes = [shape.leaf_mesh(leaf) for leaf in body.leaves]
        areas = np.concatenate([mesh.face_areas for mesh in meshes])
        middles = np.concatenate([mesh.vertices[mesh.faces].mean(axis=1) for mesh in meshes])
        assert body.joint is not None
        joint = body.joint.rotated(turn.T)
        found.append(MovingBody(joint, float(areas.sum()), areas @ middles / areas.sum() @ turn))
    return found


def is_same(one: MovingBody, other: MovingBody, diagonal: float) -> bool:
    """True if two joints are the same (see above)."""
    a, b = one.joint, other.joint
    if a.kind is not b.kind or abs(one.area / other.area - 1.0) > 1e-3:
        return False
    if np.linalg.norm(one.middle - other.middle) > 1e-3 * diagonal or abs(a.direction @ b.direction) < np.cos(np.deg2rad(1)):
        return False
    between = b.pivot - a.pivot
    away = np.linalg.norm(between - between @ a.direction * a.direction)
    return a.kind is JointKind.PRISMATIC or bool(away <= 0.01 * diagonal)


def main() -> int:
    """Predict every file and its changed copies."""
    parser = option_parser(__doc__, f"only {QUICK} files")
    parser.add_argument("folder", type=Path, help="folder of GLB files")
    parser.add_argument("--workspace", type=Path, default=Path("workspace"), help="workspace with networks")
    parser.add_argument("--limit", type=int, help="only the first N files")
    args = parser.parse_args()
    files = sorted(args.folder.rglob("*.glb"))[: QUICK if args.quick else args.limit]
    if not files:
        raise SystemExit(f"{args.folder}: expected GLB files")
    predictor = kinmo.Predictor(args.workspace)
    kept, joints = dict.fromkeys(CHANGES, 0), 0
    with tempfile.TemporaryDirectory() as name:
        for file in files:
            front = kinmo.load(file, up="y", front="z")
            expected = moving_bodies(predictor.predict(front), np.eye(3))
            joints += len(expected)
            for title, change in CHANGES.items():
                copy = Path(name) / "refrigerator.glb"
                write_changed(file, copy, change)
                turn = QUARTER_TURN if change is turned else np.eye(3)
                shape = kinmo.load(copy, up="y", front="x" if change is turned else "z")
                found = moving_bodies(predictor.predict(shape), turn)
                size = float(np.linalg.norm(np.ptp(np.concatenate([mesh.vertices for mesh in front.meshes()]), axis=0)))
                same = sum(any(is_same(body, other, size) for other in found) for body in expected)
                kept[title] += same
                if same < len(expected) or len(found) != len(expected):
                    print(f"{file.stem}, {title}: {same} of {len(expected)} joints stay, {len(found)} found", file=sys.stderr)
    print_table(("change", "files", "joints", "the same"), [(k, len(files), joints, v / joints) for k, v in kept.items()])
    least = min(kept.values()) / joints
    print_claims({"claim": "share of joints that stay the same", "ours": least, "peer": None, "ratio": None, "goal": GOAL,
                  "met": least >= GOAL})  # fmt: skip
    return 0


if __name__ == "__main__":
    sys.exit(main())
