"""Joints for shapes that are not in the workspace."""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from kinmo._core import __version__
from kinmo.core.digest import digest
from kinmo.core.errors import InputError, expecting
from kinmo.core.frames import TO_Y_UP, Up
from kinmo.core.names import short_name
from kinmo.core.wording import counted
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.workers import Crashed
from kinmo.dataset.workspace import Workspace
from kinmo.features.prepared_shape import leaf_meshes
from kinmo.features.shape_preparation import prepare_shape
from kinmo.io.folder_lock import locked
from kinmo.io.readers import Found, Layout, discover, read_found
from kinmo.io.readers.field import clean_text
from kinmo.io.readers.sources import fingerprint, shown
from kinmo.io.writers.joints_json_writer import Provenance, write_joints_json
from kinmo.io.writers.urdf_writer import write_urdf
from kinmo.io.writers.whole_folder import whole_folder
from kinmo.learning.model_folder import ModelFolder
from kinmo.methods import load_method
from kinmo.methods.method import Method
from kinmo.pipeline.each_shape import each_shape
from kinmo.scans.scan_reader import ENDINGS as SCAN_ENDINGS

SECONDS_PER_SHAPE = 3.0
VAST = 20.0
"""Metres across of what is hardly an object, but may be one in millimetres."""
REPAIRED_LINES = 40
"""Of shapes that had to be repaired to be read; what was done to all is in their joints.json, and in what --json prints."""
JOINTS = "joints.json"
MADE_FROM = ".made_from"
"""In a shape's folder: a digest of its files and of what predicted it, to know what is done already."""


@dataclass(frozen=True)
class Predict:
    """Predict every shape at or below `source` into a folder each below `out`, and go on past those that cannot be read.

    What is predicted is in the frame and the lengths of a shape's file, in which the axis `up` points up; URDFs are in metres,
    so many of which are a unit of that file.
    """

    source: Path
    out: Path
    workspace: Workspace
    method: str
    seed: int = 0
    device: str = "auto"
    workers: int = 1
    up: Up = "y"
    metres_per_unit: float = 1.0

    def plan(self) -> Plan:
        predicting = self._predicting()
        count = sum(1 for found, folder in self._targets() if not predicting.is_done(found, folder))
        step = f"predict {counted(count, 'shape')} into {self.out}"
        return Plan((step,) if count else (), count * SECONDS_PER_SHAPE / self.workers)

    def run(self, observer: Observer) -> Outcome:
        left_out: list[str] = []

        def leave_out(error: InputError) -> None:
            left_out.append(str(error))
            observer.problem(f"left out: {error}")

        targets = self._targets(leave_out)
        if not targets and not left_out:
            if self.out.resolve() == self.source.resolve():
                raise InputError("--out", "is the folder with the shapes: name another")
            scans = sum(path.suffix.lower() in SCAN_ENDINGS for path in self.source.rglob("*"))
            of_scans = f", and not {counted(scans, 'scan')}, of which --category says what they show" if scans else ""
            raise InputError(self.source, f"expected at least one shape at or below it{of_scans}")
        predicting = self._predicting()
        with locked(self.out):
            problems = self._predict(targets, predicting, observer)
        documents = []
        for found, folder in targets:
            try:
                if folder in problems:
                    left_out.append(problems[folder])
                else:
                    documents.append(_document(found, folder))
            except InputError as error:
                leave_out(error)
        data = {"shapes": documents, "left_out": left_out}
        joints = sum(document["joints"] for document in documents)
        repaired = [document for document in documents if document["repairs"]]
        for document in repaired[:REPAIRED_LINES]:
            observer.note(f"repaired: {document['id']}: {'; '.join(document['repairs'])}")
        mended = f", {len(repaired)} repaired" if repaired else ""
        for document in documents:
            if (across := document["diagonal"] * self.metres_per_unit) > VAST:
                observer.note(f"{document['id']}: {across:.0f} m across in its URDF: is a unit a metre? (--metres-per-unit)")
        text = f"{counted(len(documents), 'shape')}, {counted(joints, 'joint')}{mended}, {len(left_out)} left out"
        return Outcome(self.out, data, text, failed=len(left_out))

    def _predict(self, targets: Sequence[tuple[Found, Path]], predicting: Predicting, observer: Observer) -> dict[Path, str]:
        """Predict what was not predicted before from the same files in the same way; the problems there are, by folder."""
        problems: dict[Path, str] = {}
        jobs = []
        for found, folder in targets:
            try:
                made_from = predicting.made_from(found)
            except InputError as error:
                problems[folder] = str(error)
                observer.problem(f"left out: {error}")
                continue
            if not _is_made_from(folder, made_from):
                jobs.append(Job(found, folder, made_from))
        done = len(targets) - len(jobs)
        for job, problem in each_shape(predicting, jobs, self.workers, self.device):
            if isinstance(problem, Crashed):
                problem = f"{shown(job.found.path)}: cannot be predicted: {problem.why}"
            if problem is not None:
                problems[job.folder] = problem
                observer.problem(f"left out: {problem}")
            done += 1
            observer.progress("predicting joints", done, len(targets), job.found.id)
        return problems

    def _predicting(self) -> Predicting:
        predictor = load_method(self.method, ModelFolder(self.workspace.motion.models), self.device)
        return Predicting(predictor, self.seed, self.up, self.metres_per_unit)

    def _targets(self, report: Callable[[InputError], None] = lambda error: None) -> list[tuple[Found, Path]]:
        """Every shape with its own folder, which has its id for a name.

        Those that share an id are told apart by where they are below `source`, however many there are; but one in the layout of
        PartNet-Mobility, if it is the only one, keeps it, as that is what its URDF is looked for by. Long names are cut.
        """
        shapes = list(discover(self.source, skip=(self.out,), report=report))
        names = [short_name(found.id, found.id) for found in shapes]
        for with_endings in (False, True):
            alike = Counter(names)
            keeping = Counter(name for name, found in zip(names, shapes, strict=True) if _keeps_id(found))
            names = [
                name
                if alike[name] == 1 or (_keeps_id(found) and keeping[name] == 1)
                else _joined(found.path, self.source, with_endings)
                for name, found in zip(names, shapes, strict=True)
            ]
        if len(set(names)) < len(names):  # a folder may be called what a path becomes here
            names = [f"{number}-{name}" for number, name in enumerate(names)]
        return [(found, self.out / name) for found, name in zip(shapes, names, strict=True)]


@dataclass(frozen=True)
class Job:
    """One shape to predict into `folder`; `made_from` is a hash of all that the result depends on."""

    found: Found
    folder: Path
    made_from: str


@dataclass(frozen=True)
class Predicting:
    """Predicts and writes shapes, in whatever process."""

    predictor: Method
    seed: int
    up: Up = "y"
    metres_per_unit: float = 1.0

    def made_from(self, found: Found) -> str:
        """A hash of a shape's files and of what predicts it. Raises InputError if the files cannot be looked at."""
        how = (self.predictor.name, self.predictor.weights, self.predictor.config, self.seed, self.up, self.metres_per_unit)
        return digest([shown(found.path.absolute()), fingerprint(found), how, __version__])

    def is_done(self, found: Found, folder: Path) -> bool:
        """Whether a folder has what was predicted of a shape as it is."""
        try:
            return _is_made_from(folder, self.made_from(found))
        except InputError:
            return False

    def __call__(self, job: Job) -> str | None:
        """Write a shape's folder. Returns what is wrong with the shape, or None."""
        try:
            _check_replaceable(job.folder, job.found)
            turn = TO_Y_UP[self.up]
            x, y, z = turn[1].tolist()  # what it takes to y
            shape = replace(read_found(job.found), up=(x, y, z))
            standing = shape.turned(turn)
            prepared = prepare_shape(standing, seed=self.seed)
            prediction = self.predictor.predict(prepared, leaf_meshes(standing, prepared)).turned(turn.T)
            with whole_folder(job.folder) as draft:
                write_urdf(shape, prediction.mobility, draft, name=job.folder.name, metres_per_unit=self.metres_per_unit)
                write_joints_json(draft / JOINTS, shape, prediction, Provenance(self.predictor.weights, self.predictor.config))
                made = "".join(f"{name}\n" for name in _files(draft))
                (draft / MADE_FROM).write_text(f"{job.made_from}\n{made}", encoding="utf-8")
        except ValueError as error:
            return str(error) if isinstance(error, InputError) else f"{shown(job.found.path)}: {error}"
        except OSError as error:
            problem = f"{shown(str(error.filename or job.folder))}: {error.strerror or error}"
            return str(InputError(job.found.path, problem))
        return None


def _document(found: Found, folder: Path) -> dict[str, Any]:
    """What there is in a shape's folder."""
    with expecting("what kinmo predict writes", folder / JOINTS):
        document = json.loads((folder / JOINTS).read_text(encoding="utf-8"))
        joints = sum(body["joint"] is not None for body in document["bodies"])
        repairs = [str(repair) for repair in document["shape"].get("repairs", ())]
        diagonal = float(document["shape"]["diagonal"])
    urdf = str(folder / f"{folder.name}.urdf")
    return {
        "id": found.id,
        "source": shown(found.path),
        "folder": str(folder),
        "joints": joints,
        "urdf": urdf,
        "diagonal": diagonal,
        "repairs": repairs,
    }


def _keeps_id(found: Found) -> bool:
    return found.layout is Layout.PARTNET_MOBILITY


def _joined(path: Path, source: Path, with_ending: bool) -> str:
    """The place of a shape below `source` as the name of one folder."""
    place = path.relative_to(source)
    text = shown("__".join((place if with_ending or path.is_dir() else place.with_suffix("")).parts))
    return short_name(clean_text(text), text)


def _check_replaceable(folder: Path, found: Found) -> None:
    """Raises InputError if `folder` holds something else than what was predicted of the same shape: a user's shape, say."""
    if not os.path.lexists(folder) or _is_empty(folder):
        return
    if not (folder / MADE_FROM).is_file():
        raise InputError(folder, "is in the way, and nothing that kinmo predict wrote: name another folder by --out")
    source = _source(folder)
    if source is not None and source != shown(found.path.absolute()):
        raise InputError(folder, f"is in the way: it has what was predicted of {source}; name another folder by --out")


def _source(folder: Path) -> str | None:
    """Where the shape was that a folder has a prediction of; None if it does not say."""
    try:
        return str(json.loads((folder / JOINTS).read_text(encoding="utf-8"))["shape"]["source"])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _is_empty(folder: Path) -> bool:
    return folder.is_dir() and not any(folder.iterdir())


def _files(folder: Path) -> list[str]:
    """What is in a folder, below it too."""
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def _is_made_from(folder: Path, made_from: str) -> bool:
    """Whether a folder has all that was written there, from the same; what a user has changed since stays."""
    try:
        known, *made = (folder / MADE_FROM).read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError):
        return False
    is_whole = JOINTS in made and all((folder / name).is_file() for name in made)
    return known == made_from and is_whole and _source(folder) is not None
