"""The stage `check`: it tests saved results in simulators."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from kinmo.core.errors import InputError, did_you_mean
from kinmo.core.wording import clean_text, counted, printable_path
from kinmo.dataset.jobs import Failure, runner_for
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.io.readers.overrides_reader import OVERRIDES_FILE
from kinmo.io.writers.joints_json_writer import FILE_NAME
from kinmo.pipeline.export_results import find_results
from kinmo.pipeline.result_check import SIMULATORS, TESTS, CheckJob, FileCheck, check_result, lacks_collisions, planned_checks

SECONDS_PER_CHECK = 5.0
"""Estimate for one CPU core."""
MAX_SECONDS = 300.0
"""Longest time for the tests of a result, unless the user states another."""
MAX_LISTED_RESULTS = 50
"""Largest number of results that are all listed. Of more, those that fail are."""
MAX_NAME_LENGTH = 40
"""Longest name in the table, in characters."""
HEADER = ("object", *TESTS, "works", "problem")


@dataclass(frozen=True)
class CheckResults:
    """Test the result in a folder, or all results below it, in simulators. It writes nothing.

    Attributes:
        results: A result of kinmo predict, or a folder of results.
        simulators: Keys of `SIMULATORS`. Empty for those that are installed.
        workers: Number of results to test at once.
        seconds: Longest time for a result.
    """

    results: Path
    simulators: tuple[str, ...] = ()
    workers: int = 1
    seconds: float = MAX_SECONDS

    def plan(self) -> Plan:
        """Find the results and their files."""
        steps, impossible, count = [], [], 0
        for job in self._jobs():
            try:
                planned = planned_checks(job)
            except InputError as error:
                impossible.append(str(error))
                continue
            count += len(planned)
            steps.append(f"check {printable_path(job.folder)}: {', '.join(each.title for each in planned)}")
        return Plan(tuple(steps), count * SECONDS_PER_CHECK / self.workers, tuple(impossible), len(impossible))

    def run(self, observer: Observer) -> Outcome:
        """Test all results. One that fails or crashes does not stop the others."""
        jobs = self._jobs()
        if not self.simulators:
            for facts in SIMULATORS.values():
                if not facts.is_installed:
                    observer.note(f"not tested in {facts.title}, which is not installed: {facts.remedy}")
        found: dict[Path, list[FileCheck] | str] = {job.folder: "" for job in jobs}
        with closing(runner_for(self.workers).run(check_result, jobs)) as finished:
            for done, (job, answer) in enumerate(finished, 1):
                name = printable_path(job.folder)
                found[job.folder] = f"{name}: cannot be tested: {answer.reason}" if isinstance(answer, Failure) else answer
                observer.progress("checking", done, len(jobs), job.folder.name)
        if bare := [folder for folder in found if lacks_collisions(folder)]:
            names = self._name(bare[0]) if len(bare) == 1 else f"{counted(len(bare), 'object')}, such as {self._name(bare[0])}"
            observer.note(f"{names}: without collision geometry (--collision none), so contacts were not tested")
        rows = [_Row(folder, self._name(folder), checks) for folder, checks in found.items()]
        failed = sum(not row.works for row in rows)
        path = jobs[0].folder if len(jobs) == 1 else self._root
        return Outcome(path, {"results": [row.data for row in rows], "works": len(rows) - failed}, _text(rows), failed)

    @property
    def _root(self) -> Path:
        return self.results.parent if self.results.name in (FILE_NAME, OVERRIDES_FILE) else self.results

    def _name(self, folder: Path) -> str:
        parts = folder.relative_to(self._root).parts
        return clean_text("/".join(parts) or folder.resolve().name)

    def _jobs(self) -> list[CheckJob]:
        """One job for each result. Raises InputError if there is none, or a simulator is unknown or not installed."""
        simulators = self.simulators or tuple(name for name, facts in SIMULATORS.items() if facts.is_installed)
        for name in simulators:
            if name not in SIMULATORS:
                known = ", ".join(SIMULATORS)
                raise InputError("--simulator", f"unknown: {name}{did_you_mean(name, SIMULATORS)}; expected {known}")
            if not SIMULATORS[name].is_installed:
                raise InputError("--simulator", f"{SIMULATORS[name].title} is not installed: {SIMULATORS[name].remedy}")
        if not simulators:
            raise InputError("--simulator", f"none is installed: {SIMULATORS['mujoco'].remedy}")
        folders = list(find_results(self._root))
        if not folders:
            remedy = "make exports with kinmo export --format joints_json,urdf to check them"
            raise InputError(self.results, f"expected a result of kinmo predict, with {FILE_NAME}, at or below it: {remedy}")
        return [CheckJob(folder, simulators, self.seconds) for folder in folders]


@dataclass(frozen=True)
class _Row:
    """The tests of one result, or the reason why it could not be tested."""

    folder: Path
    name: str
    checks: list[FileCheck] | str

    @property
    def works(self) -> bool:
        return not isinstance(self.checks, str) and all(check.works for check in self.checks)

    def passes(self, test: str) -> bool | None:
        """False if a file fails a test. None if no file was tested."""
        answers = [] if isinstance(self.checks, str) else [getattr(check, test) for check in self.checks]
        made = [answer for answer in answers if answer is not None]
        return all(made) if made else None

    @property
    def problems(self) -> list[str]:
        if isinstance(self.checks, str):
            return [self.checks]
        return [f"{check.title} {problem}" for check in self.checks for problem in check.problems]

    @property
    def cells(self) -> list[str]:
        words = {True: "yes", False: "no", None: "-"}
        first, *others = self.problems or [""]
        more = f" (and {counted(len(others), 'more problem')})" if others else ""
        name = self.name if len(self.name) <= MAX_NAME_LENGTH else f"{self.name[: MAX_NAME_LENGTH - 3]}..."
        return [name, *(words[self.passes(test)] for test in TESTS), words[self.works], f"{first}{more}"]

    @property
    def data(self) -> dict[str, Any]:
        checks = [] if isinstance(self.checks, str) else [{**asdict(check), "works": check.works} for check in self.checks]
        return {
            "folder": str(self.folder),
            **{test: self.passes(test) for test in TESTS},
            "works": self.works,
            "problems": self.problems,
            "checks": checks,
        }


def _text(rows: Sequence[_Row]) -> str:
    """The table for people, a line for each kind of file, and the total."""
    listed = rows if len(rows) <= MAX_LISTED_RESULTS else [row for row in rows if not row.works]
    table = [list(HEADER), *(row.cells for row in listed)] if listed else []
    widths = [max(len(line[column]) for line in table) for column in range(len(HEADER) - 1)] if table else []
    lines = [
        "  ".join([*(cell.ljust(width) for cell, width in zip(line, widths, strict=False)), line[-1]]).rstrip()
        for line in table
    ]
    every = [check for row in rows if not isinstance(row.checks, str) for check in row.checks]
    for title in dict.fromkeys(check.title for check in every):
        own = [check for check in every if check.title == title]
        lines.append(f"{title}: {sum(check.works for check in own)} of {len(own)} work")
    sums = [words for test in TESTS if (words := _sum(rows, test))]
    lines.append(f"{counted(len(rows), 'object')}: {', '.join(sums)}, {sum(row.works for row in rows)} work")
    return "\n".join(lines)


def _sum(rows: Sequence[_Row], test: str) -> str:
    """Number of objects that pass a test, of those for which it was made if it was not made for all. Empty if for none."""
    made = [answer for row in rows if (answer := row.passes(test)) is not None]
    among = "" if len(made) == len(rows) else f" of {len(made)}"
    return f"{sum(made)}{among} {test[:-1]}" if made else ""
