"""Share of exported objects that work in simulators: they load, stay at rest, move, and agree with kinmo's kinematics.

`kinmo check` makes the tests (docs/background/metrics.md, "Simulators"). Objects are exported with the predicted joints, or
with the annotated ones: the upper bound.

A joint is safe if at most 1 % of the probes of its body hit a part on the way through the exported range. Parts that touch the
body at rest do not count.

Usage:
    python bench/simulate.py RESULTS OUT [--formats urdf,mjcf,usd] [--joints predicted true] [--limit N] [--workers N] [--quick]

RESULTS is a folder of kinmo predict. Objects in OUT are exported once.
"""

from __future__ import annotations

import sys
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path

from common import option_parser, print_claims, print_table, rate_claim, use_one_thread

use_one_thread()
import numpy as np

from kinmo import _core
from kinmo.api.prediction import Prediction
from kinmo.core.errors import InputError
from kinmo.core.joint import JointKind
from kinmo.core.links import links_of
from kinmo.core.mobility import Mobility
from kinmo.core.motion_types import CoarseType
from kinmo.core.shape import Shape
from kinmo.core.shape_estimate import JointEstimate, ShapeEstimate
from kinmo.dataset.jobs import Failure, runner_for
from kinmo.io.writers import ExportOptions, export
from kinmo.pipeline.result_check import SIMULATORS, TESTS, CheckJob, FileCheck, check_result

QUICK = 3
GOAL = 0.95
"""Least share of objects that work, and of joints that are safe."""
TOUCH = 0.005
"""Largest distance of parts that touch at rest, in diagonals."""
MAX_SHARE = 0.01
"""Largest share of the probes of a safe joint that hit another part."""
SAMPLES = 500
STEPS = 32
SECONDS = 600.0
"""Longest time for the tests of an object."""

Job = tuple[Path, Path, tuple[str, ...], bool]
"""Folder of the prediction, folder to write, formats, and True for the annotated joints."""


def export_object(job: Job) -> Path:
    """Export one object for the tests. Returns the folder."""
    source, target, formats, is_true = job
    if target.is_dir():
        return target
    prediction = Prediction.load(source)
    shape = prediction.shape
    if is_true and shape.mobility is None:
        raise InputError(shape.source, "expected annotated joints for --joints true")
    result = _certain(shape, shape.mobility) if is_true and shape.mobility is not None else prediction.estimate
    options = ExportOptions(target.name, shape.metres_per_unit, provenance=prediction.provenance)
    export(shape, result, target, ("joints_json", *formats), options)
    return target


def _certain(shape: Shape, mobility: Mobility) -> ShapeEstimate:
    """Annotated joints as a prediction with the score 1."""
    kinds = [CoarseType.FIXED if body.joint is None else CoarseType[body.joint.kind.value] for body in mobility.bodies]
    estimates = tuple((JointEstimate(body.joint, kind, 1.0),) for body, kind in zip(mobility.bodies, kinds, strict=True))
    return ShapeEstimate(shape.id, shape.category, mobility, estimates, (), "kinmo")


def check_exported(job: Job) -> tuple[list[FileCheck], list[float]]:
    """The tests of one exported object, and for each limited joint the share of probes that hit another part."""
    folder = export_object(job)
    simulators = tuple(name for name, facts in SIMULATORS.items() if facts.is_installed)
    checks = check_result(CheckJob(folder, simulators, SECONDS))
    if isinstance(checks, str):
        raise InputError(folder, checks)
    prediction = Prediction.load(job[0])
    mobility = prediction.shape.mobility if job[3] and prediction.shape.mobility is not None else prediction.mobility
    limits = {
        name: (float(limit.get("lower", "0")), float(limit.get("upper", "0")))
        for joint in ET.parse(folder / f"{folder.name}.urdf").iter("joint")
        if (name := joint.get("name")) and (limit := joint.find("limit")) is not None and "lower" in limit.attrib
    }
    return checks, swept_shares(prediction.shape, mobility, limits)


def swept_shares(shape: Shape, mobility: Mobility, limits: dict[str, tuple[float, float]]) -> list[float]:
    """Share of probes that newly hit a part on the way to the limits, for each joint with limits in metres or radians.

    Parts that touch the body at rest do not count.
    """
    place = {leaf: index for index, leaf in enumerate(shape.leaves)}
    placed = [((mesh.vertices - shape.center) / shape.diagonal, mesh.faces) for mesh in shape.meshes()]
    meshes = _core.Meshes([vertices for vertices, _ in placed], [faces for _, faces in placed])
    shares = []
    for link in links_of(mobility):
        joint = link.joint
        if joint is None or link.body is None:
            continue
        span = limits.get(link.slide_joint_name or link.joint_name)
        moving = sorted(place[leaf] for body in mobility.descendants(link.body) for leaf in mobility.bodies[body].leaves)
        obstacles = _apart(meshes, placed, moving)
        if span is None or not obstacles:
            continue
        is_turning = joint.kind is JointKind.REVOLUTE
        unit = 1.0 if is_turning else shape.metres_per_unit * shape.diagonal
        kind = np.array([(JointKind.REVOLUTE if is_turning else JointKind.PRISMATIC).code], np.uint8)
        axis = joint.direction[None], (joint.pivot - shape.center)[None] / shape.diagonal
        ends = np.array([min(span[0], 0.0) / unit]), np.array([max(span[1], 0.0) / unit])
        *_, share = _core.sweep(meshes, moving, obstacles, kind, *axis, *ends, steps=STEPS)
        shares.append(float(share.max()))
    return shares


def _apart(meshes: _core.Meshes, placed: Sequence[tuple[np.ndarray, np.ndarray]], moving: Sequence[int]) -> list[int]:
    """Indices of the parts that do not touch the moving ones."""
    own = _core.Meshes([placed[index][0] for index in moving], [placed[index][1] for index in moving])
    points = np.concatenate([each.astype(np.float64) for each in _core.sample_surface(own, SAMPLES)[0]])
    others = sorted(set(range(len(placed))) - set(moving))
    return [other for other in others if _core.closest_points(meshes, [other], points)[0].min() > TOUCH]


def rows_of(title: str, found: dict[str, tuple[list[FileCheck], list[float]]]) -> list[list[str | float]]:
    """A row for each kind of file: the share of objects that pass each test, and that pass all."""
    rows: list[list[str | float]] = []
    kinds = dict.fromkeys(check.title for checks, _ in found.values() for check in checks)
    for kind in kinds:
        own = [check for checks, _ in found.values() for check in checks if check.title == kind]
        shares = [sum(getattr(check, test) is not False for check in own) / len(own) for test in TESTS]
        rows.append([title, kind, len(own), *shares, sum(check.works for check in own) / len(own)])
    return rows


def main() -> int:
    parser = option_parser(__doc__, f"{QUICK} objects")
    parser.add_argument("results", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--formats", default="urdf,mjcf,usd")
    parser.add_argument("--joints", nargs="+", choices=("predicted", "true"), default=["predicted"])
    parser.add_argument("--limit", type=int, help="number of objects, spread over all")
    parser.add_argument("--workers", type=int, default=2)
    args = parser.parse_args()
    folders = sorted(path.parent for path in args.results.glob("*/joints.json"))
    limit = QUICK if args.quick else args.limit or len(folders)
    folders = folders[:: max(1, len(folders) // limit)][:limit]
    rows, claims = [], []
    for title in args.joints:
        jobs = [(folder, args.out / title / folder.name, tuple(args.formats.split(",")), title == "true") for folder in folders]
        found, lost = {}, 0
        for job, answer in runner_for(args.workers).run(check_exported, jobs):
            if isinstance(answer, Failure):
                lost += 1
                print(f"{title} {job[0].name}: {answer.reason}", flush=True)
                continue
            found[job[0].name] = answer
            for check in answer[0]:
                for problem in check.problems:
                    print(f"{title} {job[0].name}: {check.title} {problem}", flush=True)
        rows += rows_of(title, found)
        works = sum(all(check.works for check in checks) for checks, _ in found.values()) / max(1, len(found) + lost)
        shares = [share for _, joints in found.values() for share in joints]
        claims.append(rate_claim(f"{title}: share of {len(jobs)} objects that work in all files", works, GOAL))
        if shares:
            safe = sum(share <= MAX_SHARE for share in shares) / len(shares)
            claims.append(rate_claim(f"{title}: share of {len(shares)} limited joints that are safe", safe, GOAL))
    print_table(["joints", "file", "objects", *TESTS, "works"], rows)
    print_claims(*claims)
    return 0


if __name__ == "__main__":
    sys.exit(main())
