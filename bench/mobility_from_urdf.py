"""URDF folders of generated objects as annotated shapes in the layout of PartNet-Mobility.

Every folder in SOURCE with a mobility.urdf and an object.json (see `urdf_objects.py`) becomes a folder of the same name in OUT.
Each visual element is a leaf with its name, below one node for each rigid body. Shapes are y-up with their front at +z.

Usage:
    python bench/mobility_from_urdf.py SOURCE OUT
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from common import print_table
from kinmo.core.categories import canonical_category
from kinmo.core.errors import InputError
from kinmo.core.frames import AXIS_VECTORS, y_up_rotation
from kinmo.core.joint import KIND_WORDS
from kinmo.core.mobility import Body, Mobility
from kinmo.core.shape import Part, Shape
from kinmo.io.readers.robot_bodies import link_poses, robot_bodies
from kinmo.io.readers.scene import placed
from kinmo.io.readers.urdf_reader import read_robot_file
from kinmo.io.writers import ExportOptions, export
from urdf_objects import FACTS_FILE, URDF_FILE


def read_urdf_object(folder: Path) -> tuple[Shape, Mapping[str, Any]]:
    """Read an object with its mobility.

    Args:
        folder: Folder with mobility.urdf and object.json.

    Returns:
        The shape, y-up with its front at +z, in metres; and the content of object.json.

    Raises:
        InputError: A file is missing or wrong, or a joint is none of kinmo's kinds.
    """
    facts = _read_facts(folder / FACTS_FILE)
    robot = read_robot_file(folder / URDF_FILE, folder)
    poses, bodies = link_poses(robot), robot_bodies(robot)
    nodes: list[Part] = []
    owned: list[tuple[int, ...]] = []
    for body in bodies:
        if body.moves and body.joint is None:
            raise InputError(folder / URDF_FILE, f"expected a hinge, slider or screw above link {body.name!r}", "joint")
        pieces = [
            (piece.name or link, placed(piece.mesh, poses[link], folder / URDF_FILE))
            for link in body.links
            for piece in robot.pieces[link]
        ]
        node = len(nodes) + 1
        leaves = tuple(range(node + 1, node + 1 + len(pieces)))
        nodes.append(Part(node, body.name, 0, leaves))
        nodes += [Part(leaf, name, node, (), mesh) for leaf, (name, mesh) in zip(leaves, pieces, strict=True)]
        owned.append(leaves)
    category = canonical_category(facts["category"])
    root = Part(0, category, None, tuple(node.id for node in nodes if not node.is_leaf))
    mobility = Mobility(tuple(Body(i, body.name, owned[i], body.parent, body.joint) for i, body in enumerate(bodies)))
    up, front = (AXIS_VECTORS[facts[key]] for key in ("up", "front"))
    shape = Shape(folder.name, category, (root, *nodes), folder, "urdf", up, mobility, front=front)
    return shape.rotated(y_up_rotation(np.array(up), np.array(front))), facts


def _read_facts(path: Path) -> dict[str, Any]:
    try:
        facts = dict(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError) as error:
        raise InputError(path, f"expected a JSON object: {error}") from error
    for key in ("up", "front"):
        if facts.get(key) not in AXIS_VECTORS:
            raise InputError(path, f"expected one of {', '.join(AXIS_VECTORS)}, found {facts.get(key)!r}", key)
    if not isinstance(facts.get("category"), str):
        raise InputError(path, "expected the name of a category", "category")
    return facts


def write_truth(folder: Path, out: Path) -> Shape:
    """Write the object in `folder` as an annotated shape into `out`, and return the shape. Raises InputError."""
    shape, facts = read_urdf_object(folder)
    assert shape.mobility is not None
    meta = {key: facts[key] for key in ("asset", "generator", "version", "licence", "seed") if key in facts}
    export(shape, shape.mobility, out, ["partnet_mobility"], ExportOptions(meta=meta))
    return replace(shape, source=out)


def main() -> int:
    """Write all objects, and print counts by kind of asset."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", type=Path, help="folder of URDF folders")
    parser.add_argument("out", type=Path, help="folder for one folder per object")
    args = parser.parse_args()
    folders = sorted(file.parent for file in args.source.glob(f"*/{URDF_FILE}"))
    if not folders:
        print(f"No folders with a {URDF_FILE} in {args.source}.", file=sys.stderr)
        return 2
    counts: dict[str, Counter[str]] = {}
    leaves: dict[str, list[int]] = {}
    for folder in folders:
        try:
            shape = write_truth(folder, args.out / folder.name)
        except InputError as error:
            print(error, file=sys.stderr)
            return 1
        asset = folder.name.rpartition("-")[0]
        count = counts.setdefault(asset, Counter())
        count["objects"] += 1
        leaves.setdefault(asset, []).append(len(shape.leaves))
        assert shape.mobility is not None
        for _, body in shape.mobility.movable():
            assert body.joint is not None
            count[KIND_WORDS[body.joint.kind]] += 1
    words = list(KIND_WORDS.values())
    head = ("asset", "objects", "hinges", "sliders", "screws", "median leaves", "most leaves")
    print_table(head, [
        (asset, count["objects"], *(count[word] for word in words), float(np.median(leaves[asset])), max(leaves[asset]))
        for asset, count in counts.items()
    ])  # fmt: skip
    return 0


if __name__ == "__main__":
    sys.exit(main())
