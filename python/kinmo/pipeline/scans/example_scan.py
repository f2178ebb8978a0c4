"""A test scan as a file, to try `kinmo predict` on."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from kinmo.core.categories import same_category
from kinmo.core.errors import InputError
from kinmo.core.wording import counted
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.scans.render_scans import RenderScans
from kinmo.pipeline.scans.scan_dataset import open_scan_dataset, scanned_categories
from kinmo.scans.files.scan_file import ScanFile
from kinmo.scans.files.scan_formats import READ_ERRORS
from kinmo.scans.files.scan_reader import write_points

MARK = "example_of"  # array beside the points with the id of the object


@dataclass(frozen=True)
class ExampleScan:
    """Write one test scan of a category to an .npz file: points in the camera's frame.

    The object is drawn by the seed; the scan is the one that shows all its parts best. Scans are rendered (by `rendering`) only
    if there are none yet. Only an earlier example is replaced.
    """

    workspace: Workspace
    category: str
    path: Path
    rendering: RenderScans
    seed: int = 0

    def plan(self) -> Plan:
        """Rendering, if needed, and writing the file."""
        self._check_replaceable()
        before = Plan((), 0.0)
        if self._is_scanned():
            self._files()  # raises if no test object was scanned
        else:
            before = self.rendering.plan()
        return Plan((*before.steps, f"write a test scan of a {self.category} to {self.path}"), before.seconds)

    def run(self, observer: Observer) -> Outcome:
        """Write the file."""
        self._check_replaceable()
        failed = 0
        if not self._is_scanned():
            scanned = self.rendering.run(observer)
            failed = scanned.failed
            for line in scanned.text.splitlines():
                observer.note(line)
        files = self._files()
        file = files[int(np.random.default_rng(self.seed).integers(len(files)))]
        seen = np.array([(file.read("parts") == part).sum(axis=1) for part in range(file.structure.part_count)])
        row = int(seen.min(axis=0).argmax())
        write_points(self.path, file.read("points", row), **{MARK: np.array(file.id)})
        return Outcome(self.path, {"scan": str(self.path), "object": file.id}, f"a scan of {file.id}", failed)

    def _files(self) -> tuple[ScanFile, ...]:
        """Scans of test objects. Raises InputError if there are none."""
        dataset = open_scan_dataset(self.workspace, self.category)
        files = dataset.files["test"]
        if not files:
            others = counted(sum(n for (_, role, _), n in dataset.others.items() if role == "test"), "other test object")
            wanted = f"a test object with {dataset.structure.in_words}, like most training objects"
            remedy = "Prepare more shapes, or name their joints (scans.joints)"
            raise InputError(self.workspace.scans / dataset.category, f"expected scans of {wanted}; found {others}. {remedy}")
        return files

    def _is_scanned(self) -> bool:
        return any(same_category(name, self.category) for name in scanned_categories(self.workspace))

    def _check_replaceable(self) -> None:
        if self.path.suffix != ".npz":
            raise InputError(self.path, "expected a name that ends in .npz", "--example")
        try:
            is_own = MARK in getattr(np.load(self.path, allow_pickle=False), "files", ())
        except READ_ERRORS:
            is_own = False
        if self.path.exists() and not is_own:
            raise InputError(self.path, "exists, and is no example: name another file", "--example")
