"""The stage `predict` for scans: it finds parts, joints and their states in users' own depth scans."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from kinmo.core.errors import InputError
from kinmo.core.wording import clean_text, counted, printable_path
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.workspace import Workspace
from kinmo.io.atomic_files import check_can_be_written, write_text_atomically
from kinmo.pipeline.scans.scan_json import scan_document, scan_name
from kinmo.pipeline.scans.scan_pictures import view_of
from kinmo.pipeline.scans.scan_predictor import ScanPredictor, choose_run
from kinmo.scans.files.camera_intrinsics import Intrinsics
from kinmo.scans.files.scan_formats import SCAN_SUFFIXES, scan_suffix
from kinmo.scans.files.scan_picture import scan_picture
from kinmo.scans.files.scan_reader import read_scan, write_points

SECONDS = 5.0
SECONDS_PER_SCAN = 0.1
"""Estimates for loading the networks, and for each scan."""
PARTS_ENDING = ".parts.npz"
"""Ending of the file with the part of every point."""
MAX_LINES = 40
"""Scans whose joints are listed on the terminal; their files and --json have all."""


@dataclass(frozen=True)
class PredictScans:
    """Find the parts of an object in a scan, or in every scan at or below a folder.

    Each scan gets NAME.json (the prediction), NAME.parts.npz (the part of every point) and NAME.svg (a picture), in folders
    like those of the scans. A problem with one scan of a folder does not stop the others.

    Attributes:
        source: A scan, or a folder with scans.
        out: Folder for the results.
        workspace: The workspace with the trained networks.
        category: Category of the objects.
        intrinsics: Camera of depth images.
        depth_scale: Number that depths are divided by.
        method: Only networks that learned from pseudo labels of this method; None for the best ones.
        seed: Seed for the choice of points.
        device: Where networks run.
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
        for link in self._links():
            observer.note(f"{link}: a link to a folder, which is skipped: name the folder itself")
        if predictor.network.config.release:
            observer.note("these networks expect the size of the whole object; they get the size of its visible part")
        if not self.source.is_dir():
            document = self._predict(predictor, targets[0], observer)
            return Outcome(targets[0].document, document, _text(document))
        documents: list[dict[str, Any]] = []
        skipped: list[str] = []
        lines: list[str] = []
        for done, target in enumerate(targets, start=1):
            try:
                documents.append(self._predict(predictor, target, observer))
                if len(documents) <= MAX_LINES:
                    lines.append(f"{target.name}: {_joints_text(documents[-1])}")
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
        text = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
        picture = scan_picture([view], clean_text(printable_path(target.scan.stem)))
        target.document.parent.mkdir(parents=True, exist_ok=True)
        write_text_atomically(target.document, text)
        write_text_atomically(target.picture, picture)
        write_points(target.parts, scan.points, parts=found.parts, places=scan.indices)
        return document

    def _links(self) -> list[str]:
        """Links to other folders, which are skipped because they may lead round in circles."""
        below = sorted(self.source.rglob("*")) if self.source.is_dir() else []
        return [
            clean_text(printable_path(path.relative_to(self.source))) for path in below if path.is_symlink() and path.is_dir()
        ]

    def _targets(self) -> list[_Target]:
        """All scans with the paths of their results. Hidden files and earlier results are skipped.

        Results have the name of the scan without its ending; they keep the ending where names would clash.

        Raises InputError where there is no scan, or the output folder cannot be written to.
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
            and not place.name.endswith(PARTS_ENDING)
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

    @property
    def document(self) -> Path:
        return self.path.with_name(f"{self.path.name}.json")

    @property
    def picture(self) -> Path:
        return self.path.with_name(f"{self.path.name}.svg")

    @property
    def parts(self) -> Path:
        return self.path.with_name(f"{self.path.name}{PARTS_ENDING}")

    def check(self) -> None:
        """Raise InputError if the results would replace anything but earlier results for the same scan."""
        try:
            written = json.loads(self.document.read_text(encoding="utf-8"))
            is_own = "schema_version" in written and written["scan"] == scan_name(self.scan)
        except (OSError, ValueError, KeyError, TypeError):
            is_own = False
        for path in (self.document, self.picture, self.parts):
            if path.exists() and not is_own:
                raise InputError(path, "exists, and is no prediction for this scan: name another folder by --out")


def _text(document: dict[str, Any]) -> str:
    lines = [f"{document['category']}: {len(document['parts'])} parts"]
    for part in document["parts"]:
        agreement = "not found" if part["inliers"] is None else f"{part['inliers']:.0%} of them agree on the pose"
        lines.append(f"  part {part['id']}: {counted(part['points'], 'point')}, {agreement}")
    lines += [f"  part {joint['part']} on part {joint['parent']}: {_joint_text(joint)}" for joint in document["joints"]]
    return "\n".join(lines)


def _joints_text(document: dict[str, Any]) -> str:
    return ", ".join(f"part {joint['part']} {_joint_text(joint)}" for joint in document["joints"])


def _joint_text(joint: dict[str, Any]) -> str:
    state = joint["state"]
    if state is None:
        return f"{joint['kind']}, state not found"
    return f"{joint['kind']}, state " + (f"{np.degrees(state):.1f}°" if joint["unit"] == "radians" else f"{state:.3f}")
