"""Statistics of procedural shapes compared with those of real objects, over the categories that both have.

Both are read from files by the same readers. A row is a mean over categories, of the mean over the shapes, joints or parts of a
category (of the median where the row says so). A row is marked if the two differ by more than a factor of two.

Usage:
    python bench/synth_realism.py [--real DIR] [--count 30] [--by-category] [--quick]
"""

from __future__ import annotations

import tempfile
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from common import REAL_OBJECTS, Cell, option_parser, print_claims, print_table, use_one_thread

use_one_thread()

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.categories import canonical_category
from kinmo.core.errors import InputError
from kinmo.core.joint import Joint, JointKind
from kinmo.core.shape import Shape
from kinmo.core.vector import distance_to_line
from kinmo.io.discover import discover
from kinmo.io.readers import PARTNET_MOBILITY
from kinmo.synth.draw import ParameterRange
from kinmo.synth.families import family_names
from kinmo.synth.generate import shape_specs, write_shapes
from part_meshes import is_curved

Array = NDArray[np.float64]
FACTOR = 2.0
FLOOR = {"line distance of the best box line": 0.005, "angle of the best box axis [deg]": 0.3}
"""Largest difference that does not count, by name of the row."""


@dataclass
class Row:
    """Values of one statistic, by category."""

    name: str
    is_median: bool = False
    values: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))

    def mean_over(self, categories: Iterable[str]) -> float:
        """Mean over categories; NaN if none has a value."""
        reduce = np.median if self.is_median else np.mean
        means = [float(reduce(self.values[category])) for category in categories if self.values.get(category)]
        return float(np.mean(means)) if means else float("nan")


class Statistics:
    """All statistics of one dataset."""

    def __init__(self) -> None:
        self.rows: dict[str, Row] = {}
        self.shapes: dict[str, int] = defaultdict(int)

    def add_value(self, name: str, category: str, value: float, *, is_median: bool = False) -> None:
        self.rows.setdefault(name, Row(name, is_median)).values[category].append(float(value))

    def add(self, shape: Shape) -> None:
        """Add the statistics of one annotated shape."""
        category = canonical_category(shape.category)
        if shape.mobility is None:
            return
        self.shapes[category] += 1
        joints = [(index, body.joint) for index, body in shape.mobility.movable() if body.joint is not None]
        self.add_value("joints a shape", category, len(joints))
        self.add_value("leaves a shape", category, len(shape.leaves))
        self.add_value("nodes a shape", category, len(shape.parts))
        self.add_value("triangles a shape (median)", category, sum(len(m.faces) for m in shape.meshes()), is_median=True)
        open_now = [rests_open(joint) for _, joint in joints]
        self.add_value("share of shapes resting open", category, float(any(open_now)))
        for leaf in shape.leaves:
            mesh = shape.parts[leaf].mesh
            assert mesh is not None
            used = mesh.corners
            size = float(np.linalg.norm(used.max(axis=0) - used.min(axis=0))) / shape.diagonal
            thin = float((used.max(axis=0) - used.min(axis=0)).min()) / shape.diagonal
            self.add_value("size of a leaf, over the diagonal (median)", category, size, is_median=True)
            self.add_value("share of leaves below 1 % of the diagonal", category, float(size < 0.01))
            self.add_value("share of leaves below 2 % of the diagonal", category, float(size < 0.02))
            self.add_value("share of leaves thinner than 1 % of the diagonal", category, float(thin < 0.01))
            self.add_value("share of curved or tilted leaves", category, float(is_curved(mesh.vertices, mesh.faces)))
        for index, joint in joints:
            self.add_value("share of joints without limits", category, float(not joint.is_limited))
            self.add_value("share of hinges", category, float(joint.kind is JointKind.REVOLUTE))
            self.add_value("share of joints whose part is no single node", category, float(nodes_needed(shape, index) > 1))
            self._add_box_errors(shape, index, joint, category)

    def _add_box_errors(self, shape: Shape, index: int, joint: Joint, category: str) -> None:
        """Add the errors of the best axis of the moving part's minimum-volume box."""
        assert shape.mobility is not None
        meshes = [shape.parts[leaf].mesh for leaf in shape.mobility.bodies[index].leaves]
        vertices = np.concatenate([m.vertices[m.faces.ravel()] for m in meshes if m is not None])
        faces = np.arange(len(vertices), dtype=np.uint32).reshape(-1, 3)
        centers, axes, halves = _core.fit_boxes(_core.Meshes([vertices], [faces]))
        cosines = np.abs(axes[0] @ joint.direction)
        angle = float(np.degrees(np.arccos(np.clip(cosines.max(), 0.0, 1.0))))
        self.add_value("angle of the best box axis [deg]", category, angle)
        if joint.has_pivot:
            best = int(np.argmax(cosines))
            others = [i for i in range(3) if i != best]
            signs = [(0, 0), (1, 1), (1, -1), (-1, 1), (-1, -1)]
            points = [
                centers[0] + sum(s * halves[0][i] * axes[0][i] for s, i in zip(pair, others, strict=True)) for pair in signs
            ]
            distance = distance_to_line(np.array(points), joint.pivot, joint.direction).min()
            self.add_value("line distance of the best box line", category, float(distance) / shape.diagonal)


def rests_open(joint: Joint) -> bool:
    """True if the joint rests more than a tenth of its range away from both limits."""
    if joint.lower is None or joint.upper is None or joint.upper <= joint.lower:
        return False
    share = (joint.rest - joint.lower) / (joint.upper - joint.lower)
    return bool(0.1 < share < 0.9)


def nodes_needed(shape: Shape, body: int) -> int:
    """Smallest number of nodes of the hierarchy that make up a body and its descendants."""
    assert shape.mobility is not None
    own = set(shape.mobility.bodies[body].leaves)
    carried = {leaf for index in shape.mobility.descendants(body) for leaf in shape.mobility.bodies[index].leaves}
    inside = [set(below) <= carried for below in shape.leaves_below]
    tops = [
        i
        for i, part in enumerate(shape.parts)
        if inside[i] and (part.parent is None or not inside[part.parent]) and own & set(shape.leaves_below[i])
    ]
    return len(tops)


def read_all(folder: Path) -> Statistics:
    """Statistics of every annotated shape below a folder that can be read."""
    statistics = Statistics()
    for found in discover(folder):
        if found.layout == PARTNET_MOBILITY:
            try:
                statistics.add(found.read())
            except InputError as error:
                print(f"skipped: {error}")
    return statistics


def main() -> None:
    """Print the table, and the claim last."""
    parser = option_parser(__doc__, "4 shapes a family")
    parser.add_argument("--real", type=Path, default=REAL_OBJECTS, help="folder of the real objects")
    parser.add_argument("--count", type=int, default=30, help="procedural shapes a family")
    parser.add_argument("--by-category", action="store_true", help="print every category as well")
    options = parser.parse_args()
    real = read_all(options.real) if options.real.is_dir() else Statistics()
    with tempfile.TemporaryDirectory() as folder:
        count = 4 if options.quick else options.count
        write_shapes(Path(folder), shape_specs(count, layouts=(PARTNET_MOBILITY,), parameter_range=ParameterRange.BOTH))
        synth = read_all(Path(folder))
    shared = sorted(real.shapes.keys() & synth.shapes.keys())
    print(f"real: {sum(real.shapes.values())} shapes of {len(real.shapes)} categories below {options.real}")
    print(
        f"procedural: {sum(synth.shapes.values())} shapes of {len(family_names())} families; {len(shared)} categories in common"
    )
    rows: list[tuple[Cell, ...]] = []
    within = 0
    for name, row in synth.rows.items():
        ours, everything = row.mean_over(shared), row.mean_over(synth.shapes)
        theirs = real.rows[name].mean_over(shared) if name in real.rows else float("nan")
        ratio = ours / theirs if theirs else float("nan")
        fits = 1 / FACTOR <= ratio <= FACTOR or abs(ours - theirs) < FLOOR.get(name, 0.0)
        within += fits
        rows.append((name, theirs, ours, ratio, "" if fits else "differs", everything))
        for category in shared if options.by_category else ():
            own, other = row.mean_over([category]), real.rows[name].mean_over([category])
            rows.append((f"    {category}", other, own, own / other if other else None, "", None))
    print_table(("statistic", "real", "procedural", "ratio", "", "all procedural"), rows)
    count = len(synth.rows)
    claim = "statistics of procedural shapes within a factor of two of real ones"
    met = within == count
    print_claims({"claim": claim, "ours": within, "peer": count, "ratio": within / count, "goal": 1.0, "met": met})


if __name__ == "__main__":
    main()
