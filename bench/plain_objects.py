"""Joints of plain objects that are modelled from boxes, balls and cylinders, as people model them for games and tests.

Each object is written as GLB, once with names and once with nodes called Cube.001 and so on, and predicted. A joint is right if
a predicted body has exactly the right parts, the right kind, and the right axis within 10 degrees.

Usage:
    python bench/plain_objects.py [--workspace DIR] [--quick]
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from common import option_parser, print_claims, print_table, rate_claim, use_one_thread

use_one_thread()
import numpy as np
import trimesh

import kinmo
from kinmo.core.joint import JointKind

Parts = dict[str, trimesh.Trimesh]
HINGE, SLIDER, SCREW = JointKind.REVOLUTE, JointKind.PRISMATIC, JointKind.SCREW
X, Y, Z = np.eye(3)
BOARD = 0.02
GOAL = 0.9
"""Least share of joints that are right."""
QUICK = ("laptop", "2 doors, 2 knobs")
MAX_ANGLE = 10.0
"""Largest angle between a right axis and the true one, in degrees."""


class Moving(NamedTuple):
    """A true body: its kind of joint, its axis, and the names of its parts."""

    kind: JointKind
    axis: np.ndarray
    parts: frozenset[str]


class PlainObject(NamedTuple):
    """An object: its parts by name, and its true bodies that move."""

    parts: Parts
    bodies: tuple[Moving, ...]


def block(low: Iterable[float], high: Iterable[float]) -> trimesh.Trimesh:
    """A box between two corners."""
    return trimesh.creation.box(bounds=[list(low), list(high)])


def ball(radius: float, center: Iterable[float]) -> trimesh.Trimesh:
    """A ball."""
    return trimesh.creation.icosphere(subdivisions=2, radius=radius).apply_translation(list(center))


def rod(radius: float, length: float, center: Iterable[float], axis: np.ndarray = Y) -> trimesh.Trimesh:
    """A cylinder about an axis through its centre."""
    rod = trimesh.creation.cylinder(radius=radius, height=length, sections=24)
    return rod.apply_transform(trimesh.geometry.align_vectors(Z, axis)).apply_translation(list(center))


def carcass(width: float, height: float, depth: float, board: float = BOARD) -> Parts:
    """A cabinet of five boards that is open to the front, which is at depth / 2."""
    x, z = width / 2, depth / 2
    return {
        "back": block((-x, 0, -z), (x, height, board - z)),
        "left_side": block((-x, 0, board - z), (board - x, height, z)),
        "right_side": block((x - board, 0, board - z), (x, height, z)),
        "bottom": block((board - x, 0, board - z), (x - board, board, z)),
        "top": block((board - x, height - board, board - z), (x - board, height, z)),
    }


def two_doors(width: float, height: float, depth: float, knobs: int) -> PlainObject:
    """A cabinet with two doors in front of it, and knobs on the first ones."""
    parts, x, z = carcass(width, height, depth), width / 2 - 0.002, depth / 2
    bodies = []
    for index, (side, sign) in enumerate((("left", -1), ("right", 1))):
        left, right = sorted((0.002 * sign, x * sign))
        own = {f"door_{side}": block((left, 0.002, z), (right, height - 0.002, z + BOARD))}
        if index < knobs:
            own[f"knob_{side}"] = ball(0.015, (0.05 * sign, height / 2, z + BOARD + 0.015))
        parts |= own
        bodies.append(Moving(HINGE, Y, frozenset(own)))
    return PlainObject(parts, tuple(bodies))


def drawers(count: int, bottom: str, *, has_boxes: bool = True) -> PlainObject:
    """A chest of drawers without boards between them. `bottom` is the name of their bottoms, which lie below the walls."""
    width, height, depth = 0.5, 0.82, 0.4
    parts, step, near, far, x = (
        carcass(width, height, depth),
        (height - 0.04) / count,
        depth / 2,
        0.03 - depth / 2,
        width / 2 - 0.03,
    )
    bodies = []
    for index in range(count):
        low, top = 0.02 + step * index, 0.02 + step * (index + 0.8)
        name = f"drawer{index}"
        own = {f"{name}_front": block((-width / 2 + 0.002, low, near), (width / 2 - 0.002, low + step - 0.01, near + BOARD))}
        if has_boxes:
            own |= {
                f"{name}_{bottom}": block((-x, low + 0.01, far), (x, low + 0.02, near)),
                f"{name}_l": block((-x, low + 0.02, far), (0.01 - x, top, near)),
                f"{name}_r": block((x - 0.01, low + 0.02, far), (x, top, near)),
                f"{name}_b": block((0.01 - x, low + 0.02, far), (x - 0.01, top, far + 0.01)),
            }
        own[f"knob{index}"] = ball(0.015, (0.0, low + step / 2, near + 0.035))
        parts |= own
        bodies.append(Moving(SLIDER, Z, frozenset(own)))
    return PlainObject(parts, tuple(bodies))


def sideboard() -> PlainObject:
    """Two drawers side by side above two doors."""
    parts = carcass(1.2, 0.8, 0.4)
    parts["divider"] = block((-0.01, 0.02, -0.18), (0.01, 0.78, 0.2))
    parts["shelf"] = block((-0.58, 0.58, -0.18), (0.58, 0.6, 0.2))
    bodies = []
    for side, left, right, knob in (("l", -0.598, -0.002, -0.05), ("r", 0.002, 0.598, 0.05)):
        drawer = {
            f"drawer_{side}": block((left, 0.592, 0.2), (right, 0.798, 0.22)),
            f"drawer_{side}_box": block((left + 0.03, 0.61, -0.15), (right - 0.03, 0.75, 0.2)),
            f"drawer_{side}_knob": ball(0.014, ((left + right) / 2, 0.7, 0.235)),
        }
        door = {
            f"door_{side}": block((left, 0.002, 0.2), (right, 0.588, 0.22)),
            f"door_{side}_knob": ball(0.014, (knob, 0.4, 0.235)),
        }
        parts |= drawer | door
        bodies += [Moving(SLIDER, Z, frozenset(drawer)), Moving(HINGE, Y, frozenset(door))]
    return PlainObject(parts, tuple(bodies))


def box_with(**lids: trimesh.Trimesh) -> PlainObject:
    """An open box with lids that turn about the x axis."""
    parts = {
        "bottom": block((-0.3, 0, -0.2), (0.3, 0.01, 0.2)),
        "left": block((-0.3, 0.01, -0.2), (-0.29, 0.4, 0.2)),
        "right": block((0.29, 0.01, -0.2), (0.3, 0.4, 0.2)),
        "front": block((-0.29, 0.01, 0.19), (0.29, 0.4, 0.2)),
        "rear": block((-0.29, 0.01, -0.2), (0.29, 0.4, -0.19)),
    }
    return PlainObject({**parts, **lids}, tuple(Moving(HINGE, X, frozenset({name})) for name in lids))


def objects() -> dict[str, PlainObject]:
    """All objects by name."""
    oven_knobs = {f"knob{index}": rod(0.02, 0.025, (-0.2 + 0.13 * index, 0.55, 0.307), Z) for index in range(4)}
    oven_door = {
        "door": block((-0.295, 0.02, 0.275), (0.295, 0.49, 0.305)),
        "handle": block((-0.25, 0.45, 0.305), (0.25, 0.465, 0.34)),
    }
    oven = {**carcass(0.6, 0.6, 0.55), "panel": block((-0.3, 0.5, 0.275), (0.3, 0.6, 0.295)), **oven_door, **oven_knobs}
    fridge_doors = (
        {
            "door_top": block((-0.35, 1.2, 0.325), (0.35, 1.8, 0.385)),
            "handle_top": block((0.28, 1.25, 0.385), (0.3, 1.55, 0.42)),
        },
        {"door_low": block((-0.35, 0, 0.325), (0.35, 1.19, 0.385)), "handle_low": block((0.28, 0.8, 0.385), (0.3, 1.12, 0.42))},
    )
    screen = {
        "screen": block((-0.17, 0.015, -0.125), (0.17, 0.24, -0.115)),
        "display": block((-0.16, 0.025, -0.115), (0.16, 0.23, -0.1145)),
    }
    laptop = {
        "base": block((-0.17, 0, -0.12), (0.17, 0.015, 0.12)),
        "keys": block((-0.14, 0.015, -0.06), (0.14, 0.018, 0.04)),
        **screen,
    }
    table_drawer = {"drawer": block((-0.25, 0.6, -0.2), (0.25, 0.69, 0.31)), "knob": ball(0.015, (0, 0.645, 0.325))}
    legs = {
        f"leg{x}{z}": block((0.55 * x - 0.03, 0, 0.3 * z - 0.03), (0.55 * x + 0.03, 0.7, 0.3 * z + 0.03))
        for x in (-1, 1)
        for z in (-1, 1)
    }
    microwave_door = {
        "door": block((-0.25, 0, 0.175), (0.125, 0.3, 0.2)),
        "handle": block((0.08, 0.05, 0.2), (0.1, 0.25, 0.225)),
    }
    return {
        "2 doors, 2 knobs": two_doors(0.8, 0.9, 0.5, 2),
        "2 doors, 1 knob": two_doors(0.8, 0.9, 0.5, 1),
        "2 doors": two_doors(0.8, 0.9, 0.5, 0),
        "2 tall doors, 2 knobs": two_doors(1.0, 2.0, 0.6, 2),
        "2 tall doors": two_doors(1.0, 2.0, 0.6, 0),
        "2 wide doors": two_doors(1.2, 0.7, 0.5, 0),
        "2 drawers": drawers(2, "base"),
        "3 drawers": drawers(3, "base"),
        "3 drawers with bottoms": drawers(3, "bottom"),
        "4 drawers": drawers(4, "panel"),
        "3 fronts of drawers": drawers(3, "base", has_boxes=False),
        "sideboard": sideboard(),
        "box with a lid": box_with(lid=block((-0.3, 0.4, -0.2), (0.3, 0.42, 0.2))),
        "box with flaps": box_with(
            front_flap=block((-0.3, 0.4, 0.001), (0.3, 0.41, 0.2)), rear_flap=block((-0.3, 0.4, -0.2), (0.3, 0.41, -0.001))
        ),
        "oven": PlainObject(
            oven, (Moving(HINGE, X, frozenset(oven_door)), *(Moving(HINGE, Z, frozenset({name})) for name in oven_knobs))
        ),
        "refrigerator": PlainObject(
            carcass(0.7, 1.8, 0.65, 0.04) | fridge_doors[0] | fridge_doors[1],
            tuple(Moving(HINGE, Y, frozenset(door)) for door in fridge_doors),
        ),
        "microwave": PlainObject(
            {**carcass(0.5, 0.3, 0.35), "panel": block((0.13, 0, 0.175), (0.25, 0.3, 0.195)), **microwave_door},
            (Moving(HINGE, Y, frozenset(microwave_door)),),
        ),
        "laptop": PlainObject(laptop, (Moving(HINGE, X, frozenset(screen)),)),
        "table with a drawer": PlainObject(
            {"top": block((-0.6, 0.7, -0.35), (0.6, 0.74, 0.35)), **legs, **table_drawer},
            (Moving(SLIDER, Z, frozenset(table_drawer)),),
        ),
        "bottle": PlainObject(
            {
                "bottle": rod(0.035, 0.18, (0, 0.09, 0)),
                "neck": rod(0.013, 0.04, (0, 0.2, 0)),
                "cap": rod(0.016, 0.02, (0, 0.222, 0)),
            },
            (Moving(SCREW, Y, frozenset({"cap"})),),
        ),
    }


def right_and_wrong(shown: PlainObject, predictor: kinmo.Predictor, file: Path, *, named: bool) -> tuple[int, int]:
    """Number of true joints that are predicted right, and of all other predicted joints."""
    scene = trimesh.Scene()
    called = {(name if named else f"Cube.{index:03}"): name for index, name in enumerate(shown.parts, start=1)}
    for title, name in called.items():
        scene.add_geometry(shown.parts[name], node_name=title, geom_name=title)
    scene.export(file)
    shape = kinmo.load(file)
    found = [
        (joint.kind, joint.joint.direction, frozenset(called[shape.parts[part].name] for part in joint.parts))
        for joint in predictor.predict(shape).joints
    ]
    least = np.cos(np.radians(MAX_ANGLE))
    right = sum(
        any(kind is true.kind and parts == true.parts and abs(axis @ true.axis) >= least for kind, axis, parts in found)
        for true in shown.bodies
    )
    return right, len(found) - right


def main() -> int:
    """Predict all objects and print how many joints are right."""
    parser = option_parser(__doc__, "two objects")
    parser.add_argument("--workspace", type=Path, default=Path("workspace"), help="workspace with networks (default: kinmo's)")
    args = parser.parse_args()
    predictor, shown = kinmo.Predictor(args.workspace, device="cpu"), objects()
    rows: list[tuple[str, int, int, int, int, int]] = []
    with tempfile.TemporaryDirectory() as folder:
        for name in QUICK if args.quick else shown:
            counts = [
                right_and_wrong(shown[name], predictor, Path(folder) / "object.glb", named=named) for named in (True, False)
            ]
            rows.append((name, len(shown[name].bodies), *counts[0], *counts[1]))
    total = [sum(row[column] for row in rows) for column in range(1, 6)]
    print_table(("object", "joints", "right", "further", "right, no names", "further"), [*rows, ("all", *total)])
    share = (total[1] + total[3]) / (2 * total[0])
    print_claims(rate_claim("share of right joints, with and without names", share, GOAL))
    return 0


if __name__ == "__main__":
    sys.exit(main())
