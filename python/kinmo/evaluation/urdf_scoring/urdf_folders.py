"""Folders of URDF files against folders of annotated shapes."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from kinmo.core.errors import InputError
from kinmo.dataset.workers import Crashed, map_unordered, or_crashed
from kinmo.evaluation.aggregate import Estimate, macro, micro, sums_of
from kinmo.evaluation.urdf_scoring.body_matching import LEAST_IOU
from kinmo.evaluation.urdf_scoring.urdf_figures import FIGURES, MEDIANS
from kinmo.evaluation.urdf_scoring.urdf_scores import FAILED, MISSING, SCORED, ObjectScore, score_urdf
from kinmo.io.atomic_files import write_text_atomically
from kinmo.io.readers import Found, Layout, discover, read_found
from kinmo.io.readers.partnet_annotation import check_annotated
from kinmo.io.readers.sources import are_alike
from kinmo.io.readers.urdf_meshes import is_file

FIRST_CHOICES = ("model.urdf", "mobility.urdf")


@dataclass(frozen=True)
class FilesReport:
    """Scores of many objects. `unreadable` holds the truths that could not be read, which nobody is judged by, with reasons."""

    objects: tuple[ObjectScore, ...]
    unreadable: dict[str, str]
    least_iou: float

    def count(self, status: str) -> int:
        """How many objects ended as `status`."""
        return sum(scored.status == status for scored in self.objects)


def score_files(
    predictions: Path,
    truth: Path,
    *,
    ids: Iterable[str] | None = None,
    least_iou: float = LEAST_IOU,
    workers: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> FilesReport:
    """Score the URDFs below `predictions` for every annotated shape below `truth`, or those with the given `ids`.

    Shapes are those in PartNet-Mobility's layout that `discover` finds, pseudo-labelled ones aside. An object without a URDF is
    missing. `progress` is told how many of how many objects are done. Raises InputError if there are no such shapes, or no URDF
    of any of them.
    """
    folders, unreadable = _truths(truth)
    if not folders:
        seen = "".join(f"; {reason}" for reason in list(unreadable.values())[:1])
        raise InputError(truth, f"expected folders with a mobility_v2.json{seen}")
    wanted = sorted(folders) if ids is None else sorted(set(ids))
    unknown = [name for name in wanted if name not in folders]
    if unknown:
        raise InputError(truth, f"expected a shape {unknown[0]!r}, found none", "ids")
    if not any(find_urdf(predictions, name) for name in wanted):
        raise InputError(predictions, f"expected URDFs called after shapes below {truth}, say {wanted[0]}.urdf, found none")
    score = partial(or_crashed, partial(_score_one, predictions=predictions, least_iou=least_iou))
    scores: dict[str, ObjectScore] = {}
    for done, (shape, found) in enumerate(map_unordered(score, (folders[name] for name in wanted), workers), start=1):
        if isinstance(found, ObjectScore):
            scores[shape.id] = found
        else:
            unreadable[shape.id] = f"{shape.path}: cannot be scored: {found.why}" if isinstance(found, Crashed) else found
        if progress is not None:
            progress(done, len(wanted))
    ordered = tuple(scores[name] for name in wanted if name in scores)
    return FilesReport(ordered, dict(sorted(unreadable.items())), least_iou)


def _truths(root: Path) -> tuple[dict[str, Found], dict[str, str]]:
    """Annotated shapes by id, and what is not looked at, by where it is: copies that differ, and links that lead elsewhere."""
    folders: dict[str, Found] = {}
    left_out: dict[str, str] = {}
    for found in discover(root, report=lambda error: left_out.update({str(error.where): str(error)})):
        if found.layout is Layout.PARTNET_MOBILITY:
            first = folders.setdefault(found.id, found)
            if first != found and not are_alike(first, found):
                problem = f"differs from another copy of {found.id}, which is read instead: {first.path}"
                left_out[str(found.path)] = str(InputError(found.path, problem))
    return folders, left_out


def _score_one(shape: Found, predictions: Path, least_iou: float) -> ObjectScore | str:
    """The score of one object, or what is wrong with its truth."""
    try:
        check_annotated(shape.path)
        truth = replace(read_found(shape), id=shape.id)
        return score_urdf(truth, find_urdf(predictions, shape.id), predictions, least_iou)
    except InputError as error:
        return str(error)


def find_urdf(predictions: Path, name: str) -> Path | None:
    """The URDF of the object `name`: `name`.urdf, else below the folder `name` the first by file name, depth and path."""
    direct = predictions / f"{name}.urdf"
    if is_file(direct):
        return direct
    choices = (f"{name}.urdf", *FIRST_CHOICES)

    def order(path: Path) -> tuple[int, int, str]:
        rank = choices.index(path.name) if path.name in choices else len(choices)
        return rank, len(path.parts), str(path)

    return min((path for path in (predictions / name).rglob("*.urdf") if is_file(path)), key=order, default=None)


def summarise(report: FilesReport, *, draws: int = 1000, seed: int = 0) -> dict[str, Any]:
    """The figures of a report: micro, macro (every category counts once) and by category, as plain values for JSON."""
    sums = sums_of(report.objects, FIGURES)
    categories = [scored.category for scored in report.objects]
    by_category = {
        name: _group([scored for scored in report.objects if scored.category == name], draws, seed)
        for name in sorted(set(categories))
    }
    return {
        "match": report.least_iou,
        "micro": _group(report.objects, draws, seed),
        "macro": _named(macro(sums, categories, draws=draws, seed=seed)),
        "categories": by_category,
        "objects": [asdict(scored) for scored in report.objects],
        "unreadable": report.unreadable,
    }


def _group(objects: Sequence[ObjectScore], draws: int, seed: int) -> dict[str, Any]:
    parts = [part for scored in objects for part in scored.parts]
    counts: dict[str, Any] = {"objects": len(objects)}
    counts |= {status: sum(scored.status == status for scored in objects) for status in (SCORED, FAILED, MISSING)}
    counts |= {"parts": len(parts), "found": sum(part.found for part in parts)}
    counts["false_positives"] = sum(scored.false_alarms for scored in objects)
    for key, value in MEDIANS:
        known = [found for part in parts if (found := value(part)) is not None]
        counts[key] = float(np.median(known)) if known else None
    return counts | _named(micro(sums_of(objects, FIGURES), draws=draws, seed=seed))


def _named(estimates: Sequence[Estimate | None]) -> dict[str, Any]:
    return {
        figure.key: None if estimate is None else asdict(estimate) for figure, estimate in zip(FIGURES, estimates, strict=True)
    }


def write_json(path: Path, summary: dict[str, Any]) -> None:
    """Write a summary as JSON."""
    write_text_atomically(path, json.dumps(summary, indent=1) + "\n")
