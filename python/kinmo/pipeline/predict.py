"""Joints for shapes that are not in the workspace."""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kinmo import __version__
from kinmo.errors import InputError
from kinmo.export.folders import whole_folder
from kinmo.export.joints_json import Provenance, write_joints_json
from kinmo.export.urdf import write_urdf
from kinmo.formats import Found, discover, read_found
from kinmo.formats.sources import fingerprint, shown
from kinmo.pipeline.predictors import Predictor, leaf_meshes, load_predictor
from kinmo.pipeline.stage import Observer, Outcome, Plan
from kinmo.prepare import prepare_shape
from kinmo.workspace import Workspace, digest, locked

SECONDS_PER_SHAPE = 3.0
JOINTS = "joints.json"
MADE_FROM = ".made_from"
"""In a shape's folder: a digest of its files and of what predicted it, to know what is done already."""


@dataclass(frozen=True)
class Predict:
    """Predict every shape at or below `source` into a folder each below `out`, and go on past those that cannot be read."""

    source: Path
    out: Path
    workspace: Workspace
    method: str
    seed: int = 0
    device: str = "auto"

    def plan(self) -> Plan:
        count = sum(1 for _ in discover(self.source))
        return Plan((f"predict {count} shapes into {self.out}",), count * SECONDS_PER_SHAPE)

    def run(self, observer: Observer) -> Outcome:
        problems: list[str] = []
        targets = list(self._targets(lambda error: problems.append(str(error))))
        if not targets and not problems:
            raise InputError(self.source, "expected at least one shape at or below it")
        predictor = load_predictor(self.workspace, self.method, self.device)
        documents = []
        with locked(self.out):
            for done, (found, folder) in enumerate(targets, start=1):
                try:
                    documents.append(self._predict(found, folder, predictor))
                except ValueError as error:
                    problems.append(str(error) if isinstance(error, InputError) else f"{shown(found.path)}: {error}")
                    observer.note(f"left out: {problems[-1]}")
                observer.progress("predicting joints", done, len(targets), found.id)
        data = {"shapes": documents, "left_out": problems}
        text = f"{len(documents)} shapes, {sum(d['joints'] for d in documents)} joints, {len(problems)} left out"
        return Outcome(self.out, data, text, failed=len(problems))

    def _targets(self, report: Callable[[InputError], None]) -> Iterator[tuple[Found, Path]]:
        """Every shape with its own folder; those that share an id are told apart by their layout and a number."""
        seen: Counter[str] = Counter()
        for found in discover(self.source, skip=(self.out,), report=report):
            seen[found.id] += 1
            name = found.id if seen[found.id] == 1 else f"{found.id}-{found.layout.value}-{seen[found.id]}"
            yield found, self.out / name

    def _predict(self, found: Found, folder: Path, predictor: Predictor) -> dict[str, Any]:
        """Predict one shape, unless that was done before from the same files in the same way."""
        provenance = Provenance(predictor.weights, predictor.config)
        made_from = digest([fingerprint(found), predictor.method, predictor.weights, predictor.config, self.seed, __version__])
        if not _is_made_from(folder, made_from):
            _check_replaceable(folder)
            shape = read_found(found)
            prepared = prepare_shape(shape, seed=self.seed)
            prediction = predictor.predict(prepared, leaf_meshes(shape, prepared))
            with whole_folder(folder) as draft:
                write_urdf(shape, prediction.mobility, draft, name=folder.name)
                write_joints_json(draft / JOINTS, shape, prediction, provenance)
                (draft / MADE_FROM).write_text(made_from, encoding="ascii")
        document = json.loads((folder / JOINTS).read_text(encoding="utf-8"))
        joints = sum(body["joint"] is not None for body in document["bodies"])
        return {"id": found.id, "folder": str(folder), "joints": joints, "urdf": str(folder / f"{folder.name}.urdf")}


def _check_replaceable(folder: Path) -> None:
    """Raises InputError if `folder` holds something that was not predicted: a user's shape, say."""
    if os.path.lexists(folder) and not (folder / MADE_FROM).is_file() and not _is_empty(folder):
        raise InputError(folder, "is in the way, and nothing that kinmo predict wrote: name another folder by --out")


def _is_empty(folder: Path) -> bool:
    return folder.is_dir() and not any(folder.iterdir())


def _is_made_from(folder: Path, made_from: str) -> bool:
    try:
        return (folder / MADE_FROM).read_text(encoding="ascii") == made_from and (folder / JOINTS).exists()
    except (OSError, ValueError):
        return False
