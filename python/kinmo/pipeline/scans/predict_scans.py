"""Parts, joints and their states in a user's own depth scans."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo._core import __version__
from kinmo.core.errors import InputError
from kinmo.core.joint import JointKind
from kinmo.core.wording import counted
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.workspace import Workspace
from kinmo.io.atomic_files import check_can_be_written, write_text_atomically
from kinmo.io.readers.field import clean_text
from kinmo.io.readers.sources import shown
from kinmo.pipeline.scans.scan_finder import ScanFinder, networks_for
from kinmo.pipeline.scans.scan_pictures import view_of
from kinmo.scans.articulated_object import Structure
from kinmo.scans.pose_fitting import ScanEstimate
from kinmo.scans.scan_picture import scan_picture
from kinmo.scans.scan_reader import ENDINGS, Intrinsics, check_is_scan, read_scan, write_points

SCHEMA_VERSION = 1
SECONDS = 5.0
SECONDS_PER_SCAN = 0.1
LABELLED = ".parts.npz"
"""How the file ends that has the part of every point of a scan."""
LINES = 40
"""Scans of a folder whose joints are told one by one; those of all are in their files, and in what --json prints."""


@dataclass(frozen=True)
class PredictScans:
    """Find the parts of an object of `category` in a scan, or in every scan at or below a folder.

    By networks that saw pseudo labels of `method`, if it is given. Into `out` go for each all that was found (NAME.json), the
    part of every point (NAME.parts.npz), and a picture (NAME.svg), in folders as those that the scans are in. What is wrong
    with one scan of a folder is noted, and the others go on.
    """

    source: Path
    out: Path
    workspace: Workspace
    category: str
    intrinsics: Intrinsics | None = None
    depth_scale: float | None = None
    method: str | None = None
    seed: int = 0
    device: str = "auto"

    def plan(self) -> Plan:
        place, cell = networks_for(self.workspace, self.category, self.method, self.seed)
        targets = self._targets()
        if not self.source.is_dir():
            targets[0].check()
        what = str(self.source) if len(targets) == 1 else f"{len(targets)} scans below {self.source}"
        step = f"find the parts of a {cell.category} in {what} by the networks of {cell.title(place)}"
        return Plan((step,), SECONDS + len(targets) * SECONDS_PER_SCAN)

    def run(self, observer: Observer) -> Outcome:
        finder = ScanFinder.load(self.workspace, self.category, method=self.method, seed=self.seed, device=self.device)
        targets = self._targets()
        for link in self._links():
            observer.note(f"{link}: a link to a folder, which is not looked into: name the folder itself")
        if finder.network.config.normalised == "object":
            observer.note("these networks want to know how large the whole object is; what is seen of it is taken for that")
        if not self.source.is_dir():
            document = self._find(finder, targets[0], observer)
            return Outcome(targets[0].document, document, _text(document))
        documents: list[dict[str, Any]] = []
        left_out: list[str] = []
        lines: list[str] = []
        for done, target in enumerate(targets, start=1):
            try:
                documents.append(self._find(finder, target, observer))
                if len(documents) <= LINES:
                    lines.append(f"{target.name}: {_joints_text(documents[-1])}")
            except (InputError, OSError) as error:
                problem = str(error) if isinstance(error, InputError) else f"{target.name}: {self._problem_of(error)}"
                left_out.append(problem)
                observer.problem(f"left out: {problem}")
            observer.progress("looking at scans", done, len(targets), target.name)
        if len(documents) > LINES:
            lines.append(f"and {len(documents) - LINES} more")
        lines.append(f"{counted(len(documents), 'scan')}, {len(left_out)} left out")
        data = {"scans": documents, "left_out": left_out}
        return Outcome(self.out, data, "\n".join(lines), failed=len(left_out))

    def _problem_of(self, error: OSError) -> str:
        """What is wrong, with the file where that is none of the scans but one of the results."""
        problem = error.strerror or str(error)
        is_result = error.filename is not None and Path(error.filename).is_relative_to(self.out)
        return f"{shown(error.filename)} cannot be written ({problem})" if is_result else problem

    def _find(self, finder: ScanFinder, target: _Target, observer: Observer) -> dict[str, Any]:
        """Look at one scan and write what was found. Raises InputError if it cannot be read, or something is in the way."""
        target.check()
        scan = read_scan(target.scan, self.intrinsics, self.depth_scale, are_for_some=self.source.is_dir())
        found = finder.find(scan.points, seed=self.seed)
        where = f"{target.name}: " if self.source.is_dir() else ""
        count, strays = scan.behind + len(scan.points), int(found.is_stray.sum())
        for left_out, why in ((scan.behind, "not before the camera (z > 0)"), (strays, "far from all others")):
            if left_out:
                observer.note(f"{where}{left_out} of {count} points are left out: they are {why}")
        if scan.doubt is not None:
            observer.note(f"{where}{scan.doubt}")
        made_by = {"weights": finder.weights, "trained": finder.trained, "category": finder.category}
        document = scan_document(found.estimate, found.parts, finder.structure, target.scan, made_by)
        view = view_of(found.seen, found.seen_parts, found.estimate, finder.structure)
        text = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
        picture = scan_picture([view], clean_text(shown(target.scan.stem)))
        target.document.parent.mkdir(parents=True, exist_ok=True)
        write_text_atomically(target.document, text)
        write_text_atomically(target.picture, picture)
        write_points(target.labelled, scan.points, parts=found.parts, places=scan.places)
        return document

    def _links(self) -> list[str]:
        """What leads to other folders: not looked into, as it may lead round in circles."""
        below = sorted(self.source.rglob("*")) if self.source.is_dir() else []
        return [clean_text(shown(path.relative_to(self.source))) for path in below if path.is_symlink() and path.is_dir()]

    def _targets(self) -> list[_Target]:
        """Raises InputError where there is no scan or no folder to write to. Hidden files, and what was found before, are none.

        What is found in a scan has its name without the ending, in a folder with it where only that tells it from all others.
        """
        check_can_be_written(self.out)
        if not self.source.is_dir():
            check_is_scan(self.source)
            return [_Target(self.source, self.out / self.source.stem, shown(self.source.name))]
        places = (path.relative_to(self.source) for path in sorted(self.source.rglob("*")) if path.is_file())
        scans = [
            place
            for place in places
            if place.suffix.lower() in ENDINGS
            and not place.name.endswith(LABELLED)
            and not any(name.startswith(".") for name in place.parts)
        ]
        if not scans:
            raise InputError(self.source, f"expected a scan, one of {', '.join(ENDINGS)}, at or below it")
        found = [scan.with_suffix("") for scan in scans]
        while len(alike := Counter(found)) < len(found):
            found = [scan if alike[path] > 1 else path for scan, path in zip(scans, found, strict=True)]
        return [
            _Target(self.source / scan, self.out / path, clean_text(shown(scan)))
            for scan, path in zip(scans, found, strict=True)
        ]


@dataclass(frozen=True)
class _Target:
    """A scan, the path of what is found in it, without endings, and how it is called, on one line."""

    scan: Path
    path: Path
    name: str

    @property
    def document(self) -> Path:
        return self.path.with_name(f"{self.path.name}.json")

    @property
    def picture(self) -> Path:
        return self.path.with_name(f"{self.path.name}.svg")

    @property
    def labelled(self) -> Path:
        return self.path.with_name(f"{self.path.name}{LABELLED}")

    def check(self) -> None:
        """Raises InputError if what is to be written would replace what kinmo has not found in the same scan."""
        try:
            written = json.loads(self.document.read_text(encoding="utf-8"))
            is_own = "schema_version" in written and written["scan"] == _name_of(self.scan)
        except (OSError, ValueError, KeyError, TypeError):
            is_own = False
        for path in (self.document, self.picture, self.labelled):
            if path.exists() and not is_own:
                problem = "is in the way, and not what kinmo predict found in this scan: name another folder by --out"
                raise InputError(path, problem)


def scan_document(
    found: ScanEstimate, of_points: NDArray[np.integer], structure: Structure, source: Path, made_by: Mapping[str, str]
) -> dict[str, Any]:
    """What was found, in the frame and the lengths of the scan (x to the right, y down, z forward); null where unknown.

    `of_points` [n] are the parts of the scan's points; `made_by` are facts about the networks.
    """
    parts = [
        {
            "id": part,
            "points": int((of_points == part).sum()),
            "inliers": _number(found.inliers[part]),
            "box": {
                "center": _list(found.centers[part]),
                "axes": _list(found.poses.rotations[part].T),
                "half_sizes": _list(found.half_extents[part]),
            },
            "pose": {
                "rotation": _list(found.poses.rotations[part]),
                "scale": _number(found.poses.scales[part]),
                "translation": _list(found.poses.translations[part]),
            },
        }
        for part in range(structure.part_count)
    ]
    has_axis = np.asarray(np.isfinite(found.directions).all(axis=1))
    joints = [
        {
            "part": row + 1,
            "parent": structure.parents[row],
            "kind": kind.value,
            "direction": _list(found.directions[row]),
            "pivot": _list(found.pivots[row]) if kind is not JointKind.PRISMATIC and has_axis[row] else None,
            "state": _number(found.states[row]),
            "turn": _number(found.turns[row]),
            "unit": "radians" if kind is JointKind.REVOLUTE else "lengths of the scan",
        }
        for row, kind in enumerate(structure.kinds)
    ]
    return {
        "schema_version": SCHEMA_VERSION,
        "kinmo": __version__,
        **made_by,
        "scan": _name_of(source),
        "parts": parts,
        "joints": joints,
    }


def _name_of(scan: Path) -> str:
    """The same for a file wherever one stands, and however it is spelled."""
    return shown(scan.resolve())


def _text(document: dict[str, Any]) -> str:
    lines = [f"{document['category']}: {len(document['parts'])} parts"]
    for part in document["parts"]:
        agree = "not found" if part["inliers"] is None else f"{part['inliers']:.0%} of those looked at agree on where it is"
        lines.append(f"  part {part['id']}: {counted(part['points'], 'point')}, {agree}")
    lines += [f"  part {joint['part']} on part {joint['parent']}: {_joint_text(joint)}" for joint in document["joints"]]
    return "\n".join(lines)


def _joints_text(document: dict[str, Any]) -> str:
    return ", ".join(f"part {joint['part']} {_joint_text(joint)}" for joint in document["joints"])


def _joint_text(joint: dict[str, Any]) -> str:
    state = joint["state"]
    if state is None:
        return f"{joint['kind']}, state not found"
    return f"{joint['kind']}, state " + (f"{np.degrees(state):.1f}°" if joint["unit"] == "radians" else f"{state:.3f}")


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _list(values: NDArray[np.float64] | Sequence[float]) -> Any:
    array = np.asarray(values, np.float64)
    return array.tolist() if np.isfinite(array).all() else None
