"""Parents of bodies: share of moving bodies that get the annotated parent, with the true bodies and joints given.

Beside the tree of `kinmo.methods.kinmo.body_parents`, each body gets the other body that it has most contact with. Bodies at
rest count as one. The ten families with the most errors have a row each.

Usage:
    python bench/parents.py SHAPES [--every N] [--quick]

SHAPES is a folder of annotated shapes, such as that of `kinmo synth SHAPES --count 9 --layout partnet_mobility`.
"""

from __future__ import annotations

import re
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from common import Cell, option_parser, print_claims, print_table, rate_claim, use_one_thread

use_one_thread()
import numpy as np

from kinmo.core.frames import y_up_rotation
from kinmo.core.joint import Joint
from kinmo.core.shape import Shape
from kinmo.features.prepared_shape import leaf_meshes
from kinmo.features.shape_geometry import ShapeGeometry
from kinmo.features.shape_preparation import prepare_shape
from kinmo.io.discover import discover
from kinmo.methods.kinmo.body_parents import contacts, find_parents

QUICK = 20
GOAL = 0.95
TREE, MOST = "tree", "most contact"


def wrong_parents(shape: Shape) -> tuple[int, dict[str, int]]:
    """Number of moving bodies with a parent, and of those that get another one, by the way to find it."""
    standing = shape.rotated(y_up_rotation(np.array(shape.up), None if shape.front is None else np.array(shape.front)))
    prepared = prepare_shape(standing, seed=0)
    geometry = ShapeGeometry.of_prepared(prepared, leaf_meshes(standing, prepared))
    mobility, _ = prepared.annotation
    bodies, joints = prepared.body_leaves, [body.joint for body in mobility.bodies]
    place = {body.id: index for index, body in enumerate(mobility.bodies)}
    true = [None if body.parent is None else place[body.parent] for body in mobility.bodies]
    counted = [
        index for index, parent in enumerate(true) if joints[index] is not None and parent is not None and bodies[parent]
    ]
    found = {
        TREE: find_parents(geometry, bodies, joints),
        MOST: [_most(geometry, bodies, joints, i) for i in range(len(bodies))],
    }
    wrong = {way: sum(not _same(own[index], true[index], joints) for index in counted) for way, own in found.items()}
    return len(counted), wrong


def _most(geometry: ShapeGeometry, bodies: Sequence[Sequence[int]], joints: Sequence[Joint | None], index: int) -> int | None:
    weights = {} if joints[index] is None else contacts(geometry, bodies, [None] * len(bodies), index)
    return max(weights, key=lambda other: weights[other]) if weights else None


def _same(one: int | None, other: int | None, joints: Sequence[Joint | None]) -> bool:
    return one == other or (one is not None and other is not None and joints[one] is joints[other] is None)


def main() -> int:
    parser = option_parser(__doc__, f"{QUICK} shapes")
    parser.add_argument("shapes", type=Path)
    parser.add_argument("--every", type=int, default=1, help="Test only every Nth shape.")
    args = parser.parse_args()
    sources = list(discover(args.shapes))
    sources = sources[:: max(1, len(sources) // QUICK)][:QUICK] if args.quick else sources[:: args.every]
    bodies: Counter[str] = Counter()
    wrong: dict[str, Counter[str]] = {TREE: Counter(), MOST: Counter()}
    for source in sources:
        shape = source.read()
        if shape.mobility is None:
            continue
        family = re.split(r"-\d", source.id)[0] if "-" in source.id else shape.category
        count, errors = wrong_parents(shape)
        bodies[family] += count
        for way, number in errors.items():
            wrong[way][family] += number
    total = max(1, sum(bodies.values()))
    worst = [family for family, _ in (wrong[MOST] + wrong[TREE]).most_common(10)]
    rows: list[list[Cell]] = [[family, bodies[family], wrong[TREE][family], wrong[MOST][family]] for family in worst]
    rows.append(["all", sum(bodies.values()), wrong[TREE].total(), wrong[MOST].total()])
    print_table(["family", "moving bodies", f"wrong, {TREE}", f"wrong, {MOST}"], rows)
    print_claims(rate_claim(f"share of {total} parents that are right", 1.0 - wrong[TREE].total() / total, GOAL))
    return 0


if __name__ == "__main__":
    sys.exit(main())
