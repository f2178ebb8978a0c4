"""Tests of the files of one result in simulators, in a process of their own: a simulator may crash, hang or print."""

from __future__ import annotations

import ctypes
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from kinmo.core.errors import InputError
from kinmo.core.wording import clean_text, printable_path
from kinmo.evaluation.simulation.expected_kinematics import expected_kinematics
from kinmo.evaluation.simulation.object_check import SimulationCheck, check_object
from kinmo.evaluation.simulation.simulator import LoadError
from kinmo.io.readers.joints_json_reader import UNIT_TOLERANCE, bodies_in, read_document
from kinmo.io.readers.json_field import JsonField
from kinmo.io.result_folder import PREDICT_AGAIN
from kinmo.io.writers.joints_json_writer import FILE_NAME

REPORT, OUTPUT = "report.jsonl", "output.txt"
"""Files of the process: its results, and all that simulators print."""
ENDINGS = {"urdf": ".urdf", "mjcf": ".xml", "usd": ".usd"}
"""Endings of the files that can be tested, by format."""
BULLET_WARNING = re.compile(r"b3(?:Warning|Error)\[[^\]]*\]:")
"""Beginning of a warning of PyBullet."""
TESTS = ("loads", "rests", "moves", "agrees")


@dataclass(frozen=True)
class SimulatorFacts:
    """A simulator that results can be tested in.

    Attributes:
        title: its name for people.
        module: the Python module that it needs.
        remedy: command that installs it.
        formats: formats that it reads.
    """

    title: str
    module: str
    remedy: str
    formats: tuple[str, ...]

    @property
    def is_installed(self) -> bool:
        return find_spec(self.module) is not None


SIMULATORS = {
    "mujoco": SimulatorFacts("MuJoCo", "mujoco", "pip install 'kinmo[sim]'", ("urdf", "mjcf")),
    "pybullet": SimulatorFacts("PyBullet", "pybullet", "pip install pybullet", ("urdf",)),
    "usd": SimulatorFacts("usd-core", "pxr", "pip install 'kinmo[usd]'", ("usd",)),
}
"""All simulators, by the name that a user gives. usd-core has no physics: it loads and validates."""


@dataclass(frozen=True)
class FileCheck:
    """Results of the tests of one file in one simulator. None is a test that was not made.

    Attributes:
        format: format of the file, a key of `ENDINGS`.
        simulator: key of `SIMULATORS`.
        loads, rests, moves, agrees: see `kinmo.evaluation.simulation.object_check`.
        problems: one line for each problem.
    """

    format: str
    simulator: str
    loads: bool | None = None
    rests: bool | None = None
    moves: bool | None = None
    agrees: bool | None = None
    problems: tuple[str, ...] = ()

    @property
    def works(self) -> bool:
        """True if it loads and fails no test."""
        return bool(self.loads) and False not in (self.rests, self.moves, self.agrees) and not self.problems

    @property
    def title(self) -> str:
        """The file and the simulator, such as "URDF in MuJoCo"."""
        return f"{self.format.upper()} in {SIMULATORS[self.simulator].title}"


@dataclass(frozen=True)
class CheckJob:
    """A result to test.

    Attributes:
        folder: the folder with joints.json.
        simulators: keys of `SIMULATORS`, all of them installed.
        seconds: longest time for all tests.
    """

    folder: Path
    simulators: tuple[str, ...]
    seconds: float


def planned_checks(job: CheckJob) -> list[FileCheck]:
    """The files of a result, and the simulators that read them. Raises InputError if there is none, or joints.json is bad."""
    with _naming_remedy():
        document = read_document(job.folder / FILE_NAME)
    if document["export"].is_absent:
        raise document["export"].fail("expected the formats: run kinmo predict again")
    with _naming_remedy():
        formats = [item.text() for item in document["export"]["formats"].items()]
    found = [
        FileCheck(format, simulator)
        for format in ENDINGS
        if format in formats
        for simulator in job.simulators
        if format in SIMULATORS[simulator].formats
    ]
    if not found:
        wanted = [each for each in ENDINGS if any(each in SIMULATORS[name].formats for name in job.simulators)]
        readers = ", ".join(SIMULATORS[name].title for name in job.simulators)
        remedy = f"kinmo export {printable_path(job.folder)} --format {wanted[0]} writes one"
        raise InputError(printable_path(job.folder), f"has no file that {readers} can read: {remedy}")
    return found


def lacks_collisions(folder: Path) -> bool:
    """True if a result states that it was exported without collision geometry."""
    try:
        return read_document(folder / FILE_NAME)["export"]["collision"].text() == "none"
    except InputError:
        return False


@contextmanager
def _naming_remedy() -> Iterator[None]:
    """Add the remedy to errors of a damaged joints.json."""
    try:
        yield
    except InputError as error:
        raise InputError(error.where, f"{error.problem}: {PREDICT_AGAIN}", error.field) from None


def check_result(job: CheckJob) -> list[FileCheck] | str:
    """Test all files of a result in a process of their own. Returns a message if that is impossible."""
    try:
        planned = planned_checks(job)
        with _naming_remedy():
            _Expected.read(job.folder)
    except InputError as error:
        return str(error)
    finished, end = _in_own_process(job, planned)
    if len(finished) < len(planned):
        current, *rest = planned[len(finished) :]
        finished.append(FileCheck(current.format, current.simulator, problems=(end,)))
        finished += [
            FileCheck(each.format, each.simulator, problems=("was not tested, as the test before it did not end",))
            for each in rest
        ]
    return finished


def _in_own_process(job: CheckJob, planned: list[FileCheck]) -> tuple[list[FileCheck], str]:
    """The tests that ended, and why there are no more if some are missing."""
    order = {"folder": str(job.folder.absolute()), "checks": [[each.format, each.simulator] for each in planned]}
    paths = os.pathsep.join(str(Path(place).absolute()) for place in sys.path if place)
    end = ""
    with tempfile.TemporaryDirectory() as place:  # a folder of its own: MuJoCo writes its log into the working folder
        report = Path(place) / REPORT
        report.touch()
        with (Path(place) / OUTPUT).open("wb") as output:
            try:
                code = subprocess.run(
                    [sys.executable, "-c", "from kinmo.pipeline.result_check import main; main()", json.dumps(order)],
                    cwd=place,
                    env={**os.environ, "PYTHONPATH": paths},
                    stdin=subprocess.DEVNULL,
                    stdout=output,
                    stderr=subprocess.STDOUT,
                    timeout=job.seconds,
                    check=False,
                ).returncode
                if code < 0:
                    end = f"crashed the simulator ({_signal_name(-code)})"
                elif code > 0:
                    lines = (Path(place) / OUTPUT).read_text(errors="replace").strip().splitlines()
                    end = f"ended with an error: {clean_text(lines[-1]) if lines else code}"
            except subprocess.TimeoutExpired:
                end = f"takes more than {job.seconds:.0f} s: give it more by --time-limit"
        lines = report.read_text(encoding="utf-8").splitlines()
    entries = [json.loads(line) for line in lines if line.endswith("}")]
    return [FileCheck(**{**entry, "problems": tuple(entry["problems"])}) for entry in entries], end


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


def main() -> None:
    """Test the files that the first argument names, and append the results to `REPORT` in the working folder."""
    order = json.loads(sys.argv[1])
    folder = Path(order["folder"])
    expected = _Expected.read(folder)
    for format, simulator in order["checks"]:
        path = folder / f"{expected.name}{ENDINGS[format]}"
        line = json.dumps(asdict(_check(format, simulator, path, expected)))
        with Path(REPORT).open("a", encoding="utf-8") as report:
            report.write(f"{line}\n")


@dataclass(frozen=True, eq=False)
class _Expected:
    """Facts in joints.json: the name of the files, and the kinematics."""

    name: str
    diagonal: float
    document: JsonField

    @staticmethod
    def read(folder: Path) -> _Expected:
        """Read and check joints.json. Raises InputError if it is damaged."""
        document = read_document(folder / FILE_NAME)
        export, shape = document["export"], document["shape"]
        for length in (export["metres_per_unit"], shape["diagonal"]):
            if length.number() <= 0.0:
                raise length.fail("expected a positive number")
        name = export["name"].text()
        if not name or Path(name).name != name:
            raise export["name"].fail("expected a name of a file without a folder")
        if abs(float(np.linalg.norm(shape["up"].vector())) - 1.0) > UNIT_TOLERANCE:
            raise shape["up"].fail("expected a unit vector")
        bodies_in(document)
        return _Expected(name, export["metres_per_unit"].number() * shape["diagonal"].number(), document)

    def check(self, simulator: str, path: Path) -> SimulationCheck:
        up = np.array(self.document["shape"]["up"].vector())
        kinematics = expected_kinematics(bodies_in(self.document), up, self.document["export"]["metres_per_unit"].number())
        title = SIMULATORS[simulator].title
        if simulator == "usd":
            from kinmo.evaluation.simulation.usd_stage import check_stage

            return check_stage(title, path, kinematics, self.diagonal)
        before = _output_size()
        try:
            if simulator == "mujoco":
                from kinmo.evaluation.simulation.mujoco_simulator import MujocoSimulator

                return check_object(title, MujocoSimulator(path), kinematics, self.diagonal)
            from kinmo.evaluation.simulation.pybullet_simulator import PybulletSimulator

            loaded = PybulletSimulator(path)
            if warnings := _bullet_warnings(before):
                raise LoadError(warnings[0])
            return check_object(title, loaded, kinematics, self.diagonal)
        except LoadError as error:
            reason = (_bullet_warnings(before) if simulator == "pybullet" else []) or [str(error)]
            return SimulationCheck(title, problems=(f"does not load: {reason[0]}",))


def _check(format: str, simulator: str, path: Path, expected: _Expected) -> FileCheck:
    if not path.is_file():
        remedy = f"kinmo export {printable_path(path.parent)} --format {format} writes it again"
        return FileCheck(format, simulator, False, problems=(f"does not load: {path.name} is missing: {remedy}",))
    found = expected.check(simulator, path)
    problems = tuple(clean_text(problem) for problem in found.problems)
    if not found.loads:
        return FileCheck(format, simulator, False, problems=problems)
    if simulator == "usd":
        return FileCheck(format, simulator, True, agrees=found.agrees, problems=problems)
    return FileCheck(format, simulator, True, found.rests, found.moves, found.agrees, problems)


def _output_size() -> int:
    """Bytes that this process has printed. Buffers of C are written first."""
    ctypes.CDLL(None).fflush(None)
    output = Path(OUTPUT)
    return output.stat().st_size if output.exists() else 0


def _bullet_warnings(start: int) -> list[str]:
    """Warnings that PyBullet printed since there were `start` bytes."""
    size = _output_size()
    if size <= start:
        return []
    text = Path(OUTPUT).read_bytes()[start:size].decode(errors="replace")
    return [" ".join(warning.split()) for warning in BULLET_WARNING.split(text)[1:]]
