"""Scoring of folders of URDF files against folders of annotated shapes."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from kinmo.core.errors import InputError
from kinmo.dataset.jobs import Failure, runner_for
from kinmo.evaluation.urdf_scoring.urdf_scores import ObjectScore, score_urdf
from kinmo.io.atomic_files import write_json_atomically
from kinmo.io.discover import ShapeSource, discover
from kinmo.io.readers import PARTNET_MOBILITY
from kinmo.io.readers.partnet_annotation import check_annotated
from kinmo.io.readers.robot_meshes import is_file
from kinmo.io.source_files import have_same_contents

FIRST_CHOICES = ("model.urdf", "mobility.urdf")
"""File names that are preferred in the folder of an object, after the object's own id."""


@dataclass(frozen=True)
class UrdfReport:
    """Scores of objects in the order of their ids, and the truths that could not be read, with reasons."""

    objects: tuple[ObjectScore, ...]
    unreadable: dict[str, str]


def score_urdf_folder(
    predictions: Path,
    truth: Path,
    *,
    ids: Iterable[str] | None = None,
    workers: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> UrdfReport:
    """Score the URDFs below a folder for the annotated shapes below another one.

    Shapes are those in PartNet-Mobility's layout that `discover` finds, without pseudo labels. An object without a URDF is
    missing.

    Args:
        predictions: Folder of URDFs (`find_urdf`).
        truth: Folder of annotated shapes.
        ids: Ids of the shapes to score; all if None.
        workers: Number of processes.
        progress: Called with the numbers of objects that are done, and of all.

    Raises:
        InputError: if there is no annotated shape, none with one of the `ids`, or no URDF of any of them.
    """
    folders, unreadable = _truths(truth)
    if not folders:
        reasons = "".join(f"; {reason}" for reason in list(unreadable.values())[:1])
        raise InputError(truth, f"expected folders with a mobility_v2.json{reasons}")
    wanted = sorted(folders) if ids is None else sorted(set(ids))
    unknown = [name for name in wanted if name not in folders]
    if unknown:
        raise InputError(truth, f"expected a shape {unknown[0]!r}, found none", "ids")
    if not any(find_urdf(predictions, name) for name in wanted):
        raise InputError(predictions, f"expected URDFs named after shapes below {truth}, such as {wanted[0]}.urdf, found none")
    score = partial(_score_one, predictions=predictions)
    shapes = (folders[name] for name in wanted)
    scores: dict[str, ObjectScore] = {}
    for done, (shape, found) in enumerate(runner_for(workers).run(score, shapes), start=1):
        if isinstance(found, ObjectScore):
            scores[shape.id] = found
        else:
            unreadable[shape.id] = f"{shape.path}: cannot be scored: {found.reason}" if isinstance(found, Failure) else found
        if progress is not None:
            progress(done, len(wanted))
    return UrdfReport(tuple(scores[name] for name in wanted if name in scores), dict(sorted(unreadable.items())))


def _truths(root: Path) -> tuple[dict[str, ShapeSource], dict[str, str]]:
    """Annotated shapes by id, and the reasons for skipped folders, by path: copies that differ, and links out of the folder."""
    folders: dict[str, ShapeSource] = {}
    skipped: dict[str, str] = {}
    for found in discover(root, report=lambda error: skipped.update({str(error.where): str(error)})):
        if found.layout == PARTNET_MOBILITY:
            first = folders.setdefault(found.id, found)
            if first != found and not have_same_contents(first, found):
                problem = f"differs from another copy of {found.id}, which is read instead: {first.path}"
                skipped[str(found.path)] = str(InputError(found.path, problem))
    return folders, skipped


def _score_one(shape: ShapeSource, predictions: Path) -> ObjectScore | str:
    """The score of one object, or the reason why its truth cannot be read."""
    try:
        check_annotated(shape.path)
        truth = replace(shape.read(), id=shape.id)
        return score_urdf(truth, find_urdf(predictions, shape.id), predictions)
    except InputError as error:
        return str(error)


def find_urdf(predictions: Path, name: str) -> Path | None:
    """The URDF of an object.

    `name`.urdf, else the first below the folder `name`: by file name (`name`.urdf, model.urdf, mobility.urdf, others), then
    depth, then path. None if there is none.
    """
    direct = predictions / f"{name}.urdf"
    if is_file(direct):
        return direct
    choices = (f"{name}.urdf", *FIRST_CHOICES)

    def order(path: Path) -> tuple[int, int, str]:
        rank = choices.index(path.name) if path.name in choices else len(choices)
        return rank, len(path.parts), str(path)

    return min((path for path in (predictions / name).rglob("*.urdf") if is_file(path)), key=order, default=None)


def write_json(path: Path, summary: dict[str, Any]) -> None:
    """Write a summary as JSON."""
    write_json_atomically(path, summary)
