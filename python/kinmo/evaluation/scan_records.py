"""Scores of the frames of test objects, and the measures of scan tables (docs/background/metrics.md, "Scans")."""

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
from kinmo.scans.object_structure import Structure

_ERRORS = tuple(field.name for field in fields(FrameScore))


@dataclass(frozen=True, eq=False)
class ObjectScans:
    """Scores of the frames of one test object, of one or several seeds."""

    id: str
    frames: tuple[FrameScore, ...]


@dataclass(frozen=True)
class Measure:
    """One column of the paper's scan tables.

    Attributes:
        key: Name of the field of `FrameScore`.
        title: Head of the column.
        unit: Unit of the figure.
        per_joint: True for a measure of joints (of parts 1 and up), False for one of parts (0 and up).
        factor: Factor from the field to the unit of the column.
        decimals: Number of printed decimals.
        larger_is_better: True for overlaps and accuracies, False for errors.
        kinds: The kinds of joints that a measure of joints is of.
    """

    key: str
    title: str
    unit: Unit
    per_joint: bool
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
"""The measures of all scan tables. Lengths are diagonals of the object."""
ACCURACIES: tuple[Measure, ...] = (
    Measure("rotation_ok", "within 5 deg (%)", Unit.SHARE, False, 100.0, 1, larger_is_better=True),
    Measure("pose_ok", "within 5 deg, .05 (%)", Unit.SHARE, False, 100.0, 1, larger_is_better=True),
)
"""Further measures that ANCSH's public evaluation code prints."""


def failed_frames() -> Figure[ObjectScans]:
    """The percentage of frames in which a part or an axis was not found. These count in no mean."""
    return Figure(
        "failed",
        "failed (%)",
        Unit.SHARE,
        lambda scored: (100.0 * sum(not frame.is_whole for frame in scored.frames), len(scored.frames)),
    )


def measure_figure(measure: Measure, rows: Sequence[int]) -> Figure[ObjectScans]:
    """The mean of a measure over frames and over some parts or joints.

    Args:
        measure: The measure.
        rows: Places of the parts or joints in the arrays of `FrameScore` (`measured_rows`).
    """
    return Figure(measure.key, measure.title, measure.unit, _sums(measure, list(rows)))


def measured_rows(measure: Measure, structure: Structure) -> dict[int, int]:
    """The parts that have a measure, with their places in the arrays of `FrameScore`."""
    if not measure.per_joint:
        return {part: part for part in range(structure.part_count)}
    return {row + 1: row for row, kind in enumerate(structure.kinds) if kind in measure.kinds}


def _sums(measure: Measure, rows: list[int]) -> Callable[[ObjectScans], tuple[float, float]]:
    def sums(scored: ObjectScans) -> tuple[float, float]:
        values = [float(getattr(frame, measure.key)[row]) for frame in scored.frames for row in rows]
        known = [value for value in values if math.isfinite(value)]
        return measure.factor * sum(known), len(known)

    return sums


def found_by_all(rows: Sequence[Sequence[ObjectScans]]) -> list[list[ObjectScans]]:
    """Restrict several table rows to the objects that all have, and to the parts and joints of each frame that all have found.

    What is hard to find has large errors where it is found. A row that loses it would seem to gain otherwise.

    Args:
        rows: The scored objects of each table row. Frames of an object are the same in all, in the same order.

    Returns:
        The rows with NaN for what any row has not found, objects in the order of their ids.
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
    """Masks of the errors that are known in all of several scores of a frame."""
    return {key: np.all([np.isfinite(getattr(frame, key)) for frame in frames], axis=0) for key in _ERRORS}


def _only(frame: FrameScore, known: Mapping[str, NDArray[np.bool_]]) -> FrameScore:
    return FrameScore(**{key: np.where(known[key], getattr(frame, key), np.nan) for key in _ERRORS})


def write_scores(path: Path, scores: Iterable[tuple[str, FrameScore]]) -> None:
    """Write one JSON line a frame, with the id of its object. Errors of what was not found are null."""
    lines = (json.dumps({"id": name, **{key: _plain(getattr(score, key)) for key in _ERRORS}}) + "\n" for name, score in scores)
    write_text_atomically(path, "".join(lines))


def read_scores(paths: Sequence[Path]) -> list[ObjectScans]:
    """Read files of `write_scores`.

    Returns:
        The objects in the order of their ids, each with its frames of all files.

    Raises:
        InputError: if a file cannot be read or has another form.
    """
    found: dict[str, list[FrameScore]] = {}
    for path in paths:
        try:
            for line in path.read_text(encoding="utf-8").splitlines():
                data: Mapping[str, Any] = json.loads(line)
                score = FrameScore(**{key: np.array(data[key], np.float64) for key in _ERRORS})
                found.setdefault(data["id"], []).append(score)
        except (OSError, ValueError, TypeError, KeyError) as error:
            raise InputError(path, f"expected scores of scans as kinmo eval writes them ({error})") from None
    return [ObjectScans(name, tuple(frames)) for name, frames in sorted(found.items())]


def _plain(values: Any) -> list[float | None]:
    return [float(value) if math.isfinite(value) else None for value in values]
