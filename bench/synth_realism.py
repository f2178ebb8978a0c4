"""Are procedural shapes as hard as real ones? Statistics of both side by side, over the categories that both have.

Both are read by the same readers from files. Every row is a mean over categories of the mean (or median, where the row says so)
over the shapes, joints or parts of a category. A row is flagged where the two differ by more than a factor of two.
"""

from __future__ import annotations

import argparse
import json
import os
import tempfile
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

os.environ.setdefault("RAYON_NUM_THREADS", "1")

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.categories import canonical_category
from kinmo.core.edge_labels import distance_to_line
from kinmo.core.errors import InputError
from kinmo.core.joint import Joint, JointKind
from kinmo.core.shape import Shape
from kinmo.io.readers import Layout, discover, read_found
from kinmo.synth.draw import ParameterRange
from kinmo.synth.families import family_names
from kinmo.synth.generate import Layout as SynthLayout
from kinmo.synth.generate import generate
from parts import is_curved

Array = NDArray[np.float64]
FACTOR = 2.0
FLOOR = {"line distance of the best box line": 0.005, "angle of the best box axis [deg]": 0.3}
"""Differences below these are no differences."""


@dataclass
class Row:
    """Values of one statistic by category."""

    name: str
    is_median: bool = False
    values: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))

    def of(self, categories: Iterable[str]) -> float:
        reduce = np.median if self.is_median else np.mean
        means = [float(reduce(self.values[category])) for category in categories if self.values.get(category)]
        return float(np.mean(means)) if means else float("nan")


class Statistics:
    """All rows of one dataset."""

    def __init__(self) -> None:
        self.rows: dict[str, Row] = {}
        self.shapes: dict[str, int] = defaultdict(int)

    def note(self, name: str, category: str, value: float, *, is_median: bool = False) -> None:
        self.rows.setdefault(name, Row(name, is_median)).values[category].append(float(value))

    def add(self, shape: Shape) -> None:
        """Count one labelled shape."""
        category = canonical_category(shape.category)
        if shape.mobility is None:
            return
        self.shapes[category] += 1
        joints = [(index, body.joint) for index, body in shape.mobility.movable() if body.joint is not None]
        self.note("joints a shape", category, len(joints))
        self.note("leaves a shape", category, len(shape.leaves))
        self.note("nodes a shape", category, len(shape.parts))
        self.note("triangles a shape (median)", category, sum(len(m.faces) for m in shape.meshes()), is_median=True)
        open_now = [rests_open(joint) for _, joint in joints]
        self.note("share of shapes resting open", category, float(any(open_now)))
        for leaf in shape.leaves:
            mesh = shape.parts[leaf].mesh
            assert mesh is not None
            used = mesh.corners
            size = float(np.linalg.norm(used.max(axis=0) - used.min(axis=0))) / shape.diagonal
            thin = float((used.max(axis=0) - used.min(axis=0)).min()) / shape.diagonal
            self.note("size of a leaf, over the diagonal (median)", category, size, is_median=True)
            self.note("share of leaves below 1 % of the diagonal", category, float(size < 0.01))
            self.note("share of leaves below 2 % of the diagonal", category, float(size < 0.02))
            self.note("share of leaves thinner than 1 % of the diagonal", category, float(thin < 0.01))
            self.note("share of curved or tilted leaves", category, float(is_curved(mesh.vertices, mesh.faces)))
        for index, joint in joints:
            self.note("share of joints without limits", category, float(not joint.is_limited))
            self.note("share of hinges", category, float(joint.kind is JointKind.REVOLUTE))
            self.note("share of joints whose part is no single node", category, float(nodes_needed(shape, index) > 1))
            self._box_ceiling(shape, index, joint, category)

    def _box_ceiling(self, shape: Shape, index: int, joint: Joint, category: str) -> None:
        """How near the best line of the moving part's minimum-volume box comes to the true axis."""
        assert shape.mobility is not None
        meshes = [shape.parts[leaf].mesh for leaf in shape.mobility.bodies[index].leaves]
        vertices = np.concatenate([m.vertices[m.faces.ravel()] for m in meshes if m is not None])
        faces = np.arange(len(vertices), dtype=np.uint32).reshape(-1, 3)
        centers, axes, halves = _core.fit_boxes(_core.Meshes([vertices], [faces]))
        cosines = np.abs(axes[0] @ joint.direction)
        angle = float(np.degrees(np.arccos(np.clip(cosines.max(), 0.0, 1.0))))
        self.note("angle of the best box axis [deg]", category, angle)
        if joint.has_pivot:
            best = int(np.argmax(cosines))
            others = [i for i in range(3) if i != best]
            signs = [(0, 0), (1, 1), (1, -1), (-1, 1), (-1, -1)]
            points = [
                centers[0] + sum(s * halves[0][i] * axes[0][i] for s, i in zip(pair, others, strict=True)) for pair in signs
            ]
            distance = distance_to_line(np.array(points), joint.pivot, joint.direction).min()
            self.note("line distance of the best box line", category, float(distance) / shape.diagonal)


def rests_open(joint: Joint) -> bool:
    """Whether the joint stands away from both ends of its range by more than a tenth of it."""
    if joint.lower is None or joint.upper is None or joint.upper <= joint.lower:
        return False
    share = (joint.rest - joint.lower) / (joint.upper - joint.lower)
    return bool(0.1 < share < 0.9)


def nodes_needed(shape: Shape, body: int) -> int:
    """How few nodes of the hierarchy make up the leaves of a body and of what hangs on it."""
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
    """Statistics of every labelled shape below a folder that can be read."""
    statistics = Statistics()
    for found in discover(folder):
        if found.layout is Layout.PARTNET_MOBILITY:
            try:
                statistics.add(read_found(found))
            except InputError as error:
                print(f"left out: {error}")
    return statistics


def main() -> None:
    """Print the table, then the result as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--real", type=Path, default=Path("data/partnet"), help="folder of PartNet-Mobility objects")
    parser.add_argument("--count", type=int, default=30, help="procedural shapes a family")
    parser.add_argument("--quick", action="store_true", help="4 shapes a family")
    parser.add_argument("--by-category", action="store_true", help="print every category as well")
    options = parser.parse_args()
    real = read_all(options.real) if options.real.is_dir() else Statistics()
    with tempfile.TemporaryDirectory() as folder:
        count = 4 if options.quick else options.count
        generate(Path(folder), count=count, layouts=[SynthLayout.PARTNET_MOBILITY], parameter_range=ParameterRange.BOTH)
        synth = read_all(Path(folder))
    shared = sorted(real.shapes.keys() & synth.shapes.keys())
    print(f"real: {sum(real.shapes.values())} shapes of {len(real.shapes)} categories below {options.real}")
    print(f"synth: {sum(synth.shapes.values())} shapes of {len(family_names())} families; {len(shared)} categories in common")
    within, rows = 0, 0
    print(f"{'':50s} {'real':>9s} {'synth':>9s} {'ratio':>7s}   {'all synth':>9s}")
    for name, row in synth.rows.items():
        ours, everything = row.of(shared), row.of(synth.shapes)
        theirs = real.rows[name].of(shared) if name in real.rows else float("nan")
        ratio = ours / theirs if theirs else float("nan")
        fits = 1 / FACTOR <= ratio <= FACTOR or abs(ours - theirs) < FLOOR.get(name, 0.0)
        within, rows = within + fits, rows + 1
        print(f"{name:50s} {theirs:9.3f} {ours:9.3f} {ratio:7.2f} {' ' if fits else '!'} {everything:9.3f}")
        if options.by_category:
            for category in shared:
                print(f"    {category:46s} {real.rows[name].of([category]):9.3f} {row.of([category]):9.3f}")
    claim = "statistics of procedural shapes within a factor of two of real ones"
    share = within / rows
    print(json.dumps({"claim": claim, "ours": within, "peer": rows, "ratio": share, "goal": 1.0, "met": within == rows}))


if __name__ == "__main__":
    main()
