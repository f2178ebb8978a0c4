"""The stage `predict` for scans: it finds parts, joints and their states in users' own depth scans."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo._core import __version__
from kinmo.core.errors import InputError
from kinmo.core.joint import JointKind
from kinmo.core.wording import clean_text, counted, printable_path
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.workspace import Workspace
from kinmo.io.atomic_files import check_can_be_written, write_json_atomically, write_text_atomically
from kinmo.pipeline.scans.scan_pictures import view_of
from kinmo.pipeline.scans.scan_predictor import ScanPredictor, choose_run
from kinmo.scans.files.camera_intrinsics import Intrinsics
from kinmo.scans.files.scan_formats import SCAN_SUFFIXES, scan_suffix
from kinmo.scans.files.scan_picture import scan_picture
from kinmo.scans.files.scan_reader import read_scan, write_points
from kinmo.scans.object_structure import Structure
from kinmo.scans.poses.scan_estimate import ScanEstimate

SECONDS, SECONDS_PER_SCAN = 5.0, 0.1  # estimates for loading the networks, and for each scan
DOCUMENT, PICTURE, PARTS = ".json", ".svg", ".parts.npz"
"""Endings of the results for a scan: the prediction, its picture, and the part of every point."""
SCHEMA_VERSION = 1  # of the prediction
MAX_LINES = 40  # scans whose joints are listed on the terminal; their files and --json have all


@dataclass(frozen=True)
class PredictScans:
    """Find the parts of an object in a scan, or in every scan at or below a folder.

    Each scan gets NAME.json (the prediction), NAME.parts.npz (the part of every point) and NAME.svg (a picture), in folders
    like those of the scans. A problem with one scan of a folder does not stop the others.
    """

    source: Path
    out: Path
    workspace: Workspace
    category: str
    intrinsics: Intrinsics | None = None  # camera of depth images
    depth_scale: float | None = None  # number that depths are divided by
    method: str | None = None  # only networks that learned from its pseudo labels; None for the best ones
    seed: int = 0
    device: str = "auto"

    def plan(self) -> Plan:
        """Name the networks and count the scans."""
        run = choose_run(self.workspace, self.category, self.method, self.seed)
        targets = self._targets()
        if not self.source.is_dir():
            targets[0].check()
        what = str(self.source) if len(targets) == 1 else f"{len(targets)} scans below {self.source}"
        step = f"find the parts of a {run.category} in {what} by the networks of {run}"
        return Plan((step,), SECONDS + len(targets) * SECONDS_PER_SCAN)

    def run(self, observer: Observer) -> Outcome:
        """Predict every scan."""
        predictor = ScanPredictor.load(self.workspace, self.category, method=self.method, seed=self.seed, device=self.device)
        targets = self._targets()
        for link in sorted(self.source.rglob("*")) if self.source.is_dir() else ():
            if link.is_symlink() and link.is_dir():  # it may lead round in circles
                name = clean_text(printable_path(link.relative_to(self.source)))
                observer.note(f"{name}: a link to a folder, which is skipped: name the folder itself")
        if predictor.network.config.release:
            observer.note("these networks expect the size of the whole object; they get the size of its visible part")
        if not self.source.is_dir():
            document = self._predict(predictor, targets[0], observer)
            return Outcome(targets[0].file(DOCUMENT), document, _text(document))
        documents: list[dict[str, Any]] = []
        skipped: list[str] = []
        lines: list[str] = []
        for done, target in enumerate(targets, start=1):
            try:
                documents.append(self._predict(predictor, target, observer))
                if len(documents) <= MAX_LINES:
                    joints = (f"part {joint['part']} {_joint_text(joint)}" for joint in documents[-1]["joints"])
                    lines.append(f"{target.name}: {', '.join(joints)}")
            except (InputError, OSError) as error:
                problem = str(error) if isinstance(error, InputError) else f"{target.name}: {self._problem_of(error)}"
                skipped.append(problem)
                observer.problem(f"skipped: {problem}")
            observer.progress("predicting scans", done, len(targets), target.name)
        if len(documents) > MAX_LINES:
            lines.append(f"and {len(documents) - MAX_LINES} more")
        lines.append(f"{counted(len(documents), 'scan')}, {len(skipped)} skipped")
        return Outcome(self.out, {"scans": documents, "skipped": skipped}, "\n".join(lines), failed=len(skipped))

    def _problem_of(self, error: OSError) -> str:
        """Message of a system error, with the file if it is one of the results."""
        problem = error.strerror or str(error)
        is_result = error.filename is not None and Path(error.filename).is_relative_to(self.out)
        return f"{printable_path(error.filename)} cannot be written ({problem})" if is_result else problem

    def _predict(self, predictor: ScanPredictor, target: _Target, observer: Observer) -> dict[str, Any]:
        """Predict one scan and write its files. Raises InputError if it cannot be read, or other files are in the way."""
        target.check()
        scan = read_scan(target.scan, self.intrinsics, self.depth_scale, ignore_unused_options=self.source.is_dir())
        found = predictor.predict(scan.points, seed=self.seed)
        where = f"{target.name}: " if self.source.is_dir() else ""
        count, outliers = scan.behind_count + len(scan.points), int(found.is_outlier.sum())
        for ignored, why in ((scan.behind_count, "not before the camera (z > 0)"), (outliers, "far from all others")):
            if ignored:
                observer.note(f"{where}{ignored} of {count} points are ignored: they are {why}")
        if scan.warning is not None:
            observer.note(f"{where}{scan.warning}")
        made_by = {"weights": predictor.weights, "trained": predictor.trained, "category": predictor.category}
        document = scan_document(found.estimate, found.parts, predictor.structure, target.scan, made_by)
        view = view_of(found.seen, found.seen_parts, found.estimate, predictor.structure)
        picture = scan_picture([view], clean_text(printable_path(target.scan.stem)))
        write_json_atomically(target.file(DOCUMENT), document, allow_nan=False)
        write_text_atomically(target.file(PICTURE), picture)
        write_points(target.file(PARTS), scan.points, parts=found.parts, places=scan.indices)
        return document

    def _targets(self) -> list[_Target]:
        """All scans with the paths of their results. Hidden files and earlier results are skipped.

        Results have the name of the scan without its ending; they keep the ending where names would clash. Raises InputError
        where there is no scan, or the output folder cannot be written to.
        """
        check_can_be_written(self.out)
        if not self.source.is_dir():
            scan_suffix(self.source)
            return [_Target(self.source, self.out / self.source.stem, printable_path(self.source.name))]
        places = (path.relative_to(self.source) for path in sorted(self.source.rglob("*")) if path.is_file())
        scans = [
            place
            for place in places
            if place.suffix.lower() in SCAN_SUFFIXES
            and not place.name.endswith(PARTS)
            and not any(name.startswith(".") for name in place.parts)
        ]
        if not scans:
            raise InputError(self.source, f"expected a scan, one of {', '.join(SCAN_SUFFIXES)}, at or below it")
        found = [scan.with_suffix("") for scan in scans]
        while len(counts := Counter(found)) < len(found):
            found = [scan if counts[path] > 1 else path for scan, path in zip(scans, found, strict=True)]
        return [
            _Target(self.source / scan, self.out / path, clean_text(printable_path(scan)))
            for scan, path in zip(scans, found, strict=True)
        ]


@dataclass(frozen=True)
class _Target:
    """A scan, the path of its results without ending, and its name on one line."""

    scan: Path
    path: Path
    name: str

    def file(self, ending: str) -> Path:
        """One of the results."""
        return self.path.with_name(self.path.name + ending)

    def check(self) -> None:
        """Raise InputError if the results would replace anything but earlier results for the same scan."""
        try:
            written = json.loads(self.file(DOCUMENT).read_text(encoding="utf-8"))
            is_own = "schema_version" in written and written["scan"] == scan_name(self.scan)
        except (OSError, ValueError, KeyError, TypeError):
            is_own = False
        for path in map(self.file, (DOCUMENT, PICTURE, PARTS)):
            if path.exists() and not is_own:
                raise InputError(path, "exists, and is no prediction for this scan: name another folder by --out")


def _text(document: dict[str, Any]) -> str:
    lines = [f"{document['category']}: {len(document['parts'])} parts"]
    for part in document["parts"]:
        agreement = "not found" if part["inliers"] is None else f"{part['inliers']:.0%} of them agree on the pose"
        lines.append(f"  part {part['id']}: {counted(part['points'], 'point')}, {agreement}")
    lines += [f"  part {joint['part']} on part {joint['parent']}: {_joint_text(joint)}" for joint in document["joints"]]
    return "\n".join(lines)


def _joint_text(joint: dict[str, Any]) -> str:
    state = joint["state"]
    if state is None:
        return f"{joint['kind']}, state not found"
    return f"{joint['kind']}, state " + (f"{np.degrees(state):.1f}°" if joint["unit"] == "radians" else f"{state:.3f}")


def scan_document(
    found: ScanEstimate, of_points: NDArray[np.integer], structure: Structure, source: Path, made_by: Mapping[str, str]
) -> dict[str, Any]:
    """A prediction as plain data, in the frame and units of the scan (x to the right, y down, z forward).

    Unknown values are None. `of_points` is the part [n] of every point; `made_by` are facts about the networks.
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
    versions = {"schema_version": SCHEMA_VERSION, "kinmo": __version__}
    return {**versions, **made_by, "scan": scan_name(source), "parts": parts, "joints": joints}


def scan_name(scan: Path) -> str:
    """Absolute path of a scan without links, as it is written into files."""
    return printable_path(scan.resolve())


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _list(values: NDArray[np.float64]) -> Any:
    return values.tolist() if np.isfinite(values).all() else None
