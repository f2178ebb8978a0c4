"""Errors of the frames of test objects, and the figures that they sum up to (docs/metrics.md, "Scans")."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError
from kinmo.core.joint import JointKind
from kinmo.evaluation.aggregate import Figure, Unit
from kinmo.evaluation.scan_metrics import FrameScore
from kinmo.io.atomic_files import write_text_atomically
from kinmo.scans.articulated_object import Structure

_NAMES = tuple(field.name for field in fields(FrameScore))


@dataclass(frozen=True, eq=False)
class ObjectScans:
    """What was found in the frames of one test object, by networks of one seed or of several."""

    id: str
    frames: tuple[FrameScore, ...]


@dataclass(frozen=True)
class Measure:
    """A column of the paper's tables. `of_joints`: of joints 1 and up, else of parts 0 and up; of joints those of `kinds`."""

    key: str
    title: str
    unit: Unit
    of_joints: bool
    factor: float = 1.0
    decimals: int = 2
    larger_is_better: bool = False
    kinds: tuple[JointKind, ...] = tuple(JointKind)


MEASURES: tuple[Measure, ...] = (
    Measure("rotation", "rotation (deg)", Unit.DEGREES, False, math.degrees(1.0)),
    Measure("translation", "translation", Unit.DIAGONALS, False, decimals=3),
    Measure("iou", "3D IoU (%)", Unit.SHARE, False, 100.0, 1, larger_is_better=True),
    Measure("state", "state (deg)", Unit.DEGREES, True, math.degrees(1.0), kinds=(JointKind.REVOLUTE,)),
    Measure("state", "state (diag.)", Unit.DIAGONALS, True, decimals=3, kinds=(JointKind.PRISMATIC, JointKind.SCREW)),
    Measure("turn", "turn (deg)", Unit.DEGREES, True, math.degrees(1.0), kinds=(JointKind.SCREW,)),
    Measure("axis", "axis (deg)", Unit.DEGREES, True, math.degrees(1.0)),
    Measure("line", "line", Unit.DIAGONALS, True, decimals=3, kinds=(JointKind.REVOLUTE, JointKind.SCREW)),
)
"""Lengths are diagonals of the object."""
ACCURACIES: tuple[Measure, ...] = (
    Measure("turned_right", "within 5 deg (%)", Unit.SHARE, False, 100.0, 1, larger_is_better=True),
    Measure("placed_right", "within 5 deg, .05 (%)", Unit.SHARE, False, 100.0, 1, larger_is_better=True),
)
"""What ANCSH's public evaluation code prints besides."""


def failed() -> Figure[ObjectScans]:
    """The share of frames in which a part was not found; what was not found counts in no mean."""
    return Figure(
        "failed",
        "failed (%)",
        Unit.SHARE,
        lambda scored: (100.0 * sum(not frame.is_whole for frame in scored.frames), len(scored.frames)),
    )


def of_rows(measure: Measure, rows: Sequence[int]) -> Figure[ObjectScans]:
    """The mean of a measure over frames and over the parts (or joints) with the places `rows` in `FrameScore`."""
    return Figure(measure.key, measure.title, measure.unit, _sums(measure, list(rows)))


def rows_of(measure: Measure, structure: Structure) -> dict[int, int]:
    """The parts that a measure is of, and their places in `FrameScore`."""
    if not measure.of_joints:
        return {part: part for part in range(structure.part_count)}
    return {row + 1: row for row, kind in enumerate(structure.kinds) if kind in measure.kinds}


def _sums(measure: Measure, rows: list[int]) -> Callable[[ObjectScans], tuple[float, float]]:
    def sums(scored: ObjectScans) -> tuple[float, float]:
        values = [float(getattr(frame, measure.key)[row]) for frame in scored.frames for row in rows]
        known = [value for value in values if math.isfinite(value)]
        return measure.factor * sum(known), len(known)

    return sums


def found_by_all(rows: Sequence[Sequence[ObjectScans]]) -> list[list[ObjectScans]]:
    """Of every row the objects that all have, without what any of the rows has not found of a frame.

    What is hard to find has large errors where it is found: a row that loses it would seem to gain by that. The rows are of
    the same frames, in one order.
    """
    by_id = [{scored.id: scored for scored in row} for row in rows]
    common = sorted(set(by_id[0]).intersection(*by_id))
    found: list[list[ObjectScans]] = [[] for _ in rows]
    for name in common:
        together = list(zip(*(row[name].frames for row in by_id), strict=True))
        known = [_known(frames) for frames in together]
        for place, row in enumerate(found):
            kept = (_only(frames[place], where) for frames, where in zip(together, known, strict=True))
            row.append(ObjectScans(name, tuple(kept)))
    return found


def _known(frames: Sequence[FrameScore]) -> dict[str, NDArray[np.bool_]]:
    """What all of some rows have found of a frame."""
    return {key: np.all([np.isfinite(getattr(frame, key)) for frame in frames], axis=0) for key in _NAMES}


def _only(frame: FrameScore, known: Mapping[str, NDArray[np.bool_]]) -> FrameScore:
    return FrameScore(**{key: np.where(known[key], getattr(frame, key), np.nan) for key in _NAMES})


def write_scores(path: Path, scores: Iterable[tuple[str, FrameScore]]) -> None:
    """Write one JSON line a frame, with the id of its object; what was not found is null."""
    lines = (json.dumps({"id": name, **{key: _plain(getattr(score, key)) for key in _NAMES}}) + "\n" for name, score in scores)
    write_text_atomically(path, "".join(lines))


def read_scores(paths: Sequence[Path]) -> list[ObjectScans]:
    """The objects of some files of `write_scores`, with the frames of all. Raises InputError for anything else."""
    found: dict[str, list[FrameScore]] = {}
    for path in paths:
        try:
            for line in path.read_text(encoding="utf-8").splitlines():
                data: Mapping[str, Any] = json.loads(line)
                score = FrameScore(**{key: np.array(data[key], np.float64) for key in _NAMES})
                found.setdefault(data["id"], []).append(score)
        except (OSError, ValueError, TypeError, KeyError) as error:
            raise InputError(path, f"expected errors of scans, as kinmo eval writes them ({error})") from None
    return [ObjectScans(name, tuple(frames)) for name, frames in sorted(found.items())]


def _plain(values: Any) -> list[float | None]:
    return [float(value) if math.isfinite(value) else None for value in values]
