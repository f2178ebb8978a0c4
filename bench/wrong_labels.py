"""In which way joints of pseudo labels are wrong, beside labels that were held back, and whether their parts have something,
such as a handle, that could have told better.

    python bench/wrong_labels.py WORKSPACE --category refrigerator --named handle

Of objects whose labels have the joints that networks for scans know, as `kinmo table` counts them.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

from kinmo.core.shape import Shape
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.joint_records import AXIS_WITHIN, LINE_WITHIN
from kinmo.evaluation.metrics import axis_error, line_distance_at_part
from kinmo.io.readers import Found, Layout, read_found
from kinmo.pipeline.scans.scan_dataset import open_scan_dataset
from kinmo.scans.articulated_object import articulated_object

ELSEWHERE = 0.2
"""Diagonals from which on a hinge is at another edge of its part."""
RIGHT, TURNED, OTHER_EDGE, NEAR = "right", "another direction", "at another edge", "a little off"
WAYS = (RIGHT, TURNED, OTHER_EDGE, NEAR)


def main() -> None:
    """Print how many joints are right, and how many are wrong in each way."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("workspace", type=Path)
    parser.add_argument("--category", default="refrigerator")
    parser.add_argument("--named", default="handle")
    parser.add_argument("--method", default="kinmo")
    parser.add_argument("--quick", action="store_true", help="of 20 joints")
    arguments = parser.parse_args()
    workspace = Workspace(arguments.workspace, method=arguments.method)
    counts = Counter(islice(judged(workspace, arguments.category, arguments.named), 20 if arguments.quick else None))
    whole, bare = counts.total(), sum(count for (_, has), count in counts.items() if not has)
    for way in WAYS:
        told, untold = counts[way, True], counts[way, False]
        print(f"{way}: {told + untold} of {whole} joints, {untold} of them of parts without a {arguments.named}")
    wrong = {has: sum(counts[way, has] for way in WAYS[1:]) for has in (True, False)}
    shares = {has: wrong[has] / max(count, 1) for has, count in ((True, whole - bare), (False, bare))}
    claim = f"share of wrong joints of {arguments.category} with a {arguments.named}, beside those without"
    print(json.dumps({"claim": claim, "ours": shares[True], "peer": shares[False], "ratio": None, "goal": None, "met": None}))


def judged(workspace: Workspace, category: str, named: str) -> Iterator[tuple[str, bool]]:
    """Of every joint that a pseudo label gives: in which way it is wrong, and whether its part truly has a `named` node."""
    scans, dataset = open_scan_dataset(workspace, category), open_dataset(workspace, category)
    truths = {file.id: file for file in scans.files["hidden"] if not file.provenance.variant}
    sources = {entry.id: Found(Path(entry.source), Layout(entry.layout), entry.id) for entry in dataset.hidden}
    for said in scans.files["pseudo"]:
        original = scans.truths.get(said.object)
        if said.provenance.variant or original not in truths:
            continue
        true = truths[original]
        shape = read_found(sources[original])
        bodies = articulated_object(shape).mobility.bodies[1:]
        for mine, right, middle, body in zip(said.joints, true.joints, true.extents.centers[1:], bodies, strict=True):
            line = line_distance_at_part(right, mine, middle) if right.has_pivot else 0.0
            is_turned = axis_error(mine.direction, right.direction) > AXIS_WITHIN
            way = TURNED if is_turned else OTHER_EDGE if line > ELSEWHERE else NEAR if line > LINE_WITHIN else RIGHT
            yield way, has_node(shape, body.leaves, named)


def has_node(shape: Shape, leaves: tuple[int, ...], named: str) -> bool:
    """Whether one of some leaves, or a part that holds one of them, has a name."""
    for leaf in leaves:
        node: int | None = leaf
        while node is not None:
            if shape.parts[node].name == named:
                return True
            node = shape.parts[node].parent
    return False


if __name__ == "__main__":
    main()
