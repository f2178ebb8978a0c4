"""Scores of the frames of test objects, and means of their measures in tables (docs/background/metrics.md, "Scans")."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from kinmo.core.errors import InputError
from kinmo.core.joint import JointKind
from kinmo.evaluation.aggregate import Estimates, Figure, Unit, by_key, figure_sums, paired_differences, summarise
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
    """One column of the paper's scan tables: a field of `FrameScore`, times a factor, with some printed decimals.

    Measures per joint are of parts 1 and up that have joints of some kinds, others of all parts.
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


def _failed_frames(scored: ObjectScans) -> tuple[float, float]:
    return 100.0 * sum(not frame.is_whole for frame in scored.frames), len(scored.frames)


FAILED = Figure("failed (%)", "failed (%)", Unit.SHARE, _failed_frames)
"""The percentage of frames in which a part or an axis was not found. These count in no mean."""


def measure_figure(measure: Measure, rows: Iterable[int]) -> Figure[ObjectScans]:
    """The mean of a measure over frames and over some parts or joints, at places `rows` of the arrays of `FrameScore`.

    Its key is the title, because one field has several measures.
    """
    places = list(rows)

    def sums(scored: ObjectScans) -> tuple[float, float]:
        values = [float(getattr(frame, measure.key)[place]) for frame in scored.frames for place in places]
        known = [value for value in values if math.isfinite(value)]
        return measure.factor * sum(known), len(known)

    return Figure(measure.title, measure.title, measure.unit, sums)


def measured_rows(measure: Measure, structure: Structure) -> dict[int, int]:
    """The parts that have a measure, with their places in the arrays of `FrameScore`."""
    if not measure.per_joint:
        return {part: part for part in range(structure.part_count)}
    return {row + 1: row for row, kind in enumerate(structure.kinds) if kind in measure.kinds}


def found_by_all(rows: Sequence[Sequence[ObjectScans]]) -> list[list[ObjectScans]]:
    """Restrict several table rows to the objects that all have, and to the parts and joints of each frame that all have found.

    What is hard to find has large errors where it is found. A row that loses it would seem to gain otherwise. Frames of an
    object are the same in all rows, in the same order. In the result, objects are in the order of their ids.
    """
    by_id = [{scored.id: scored.frames for scored in row} for row in rows]
    found: list[list[ObjectScans]] = [[] for _ in rows]
    for name in sorted(set(by_id[0]).intersection(*by_id)):
        frames = [_found_by_all(scores) for scores in zip(*(row[name] for row in by_id), strict=True)]
        for row, own in zip(found, zip(*frames, strict=True), strict=True):
            row.append(ObjectScans(name, own))
    return found


def _found_by_all(scores: Sequence[FrameScore]) -> list[FrameScore]:
    """Several scores of one frame with NaN for what any of them has not found."""
    known = {key: np.all([np.isfinite(getattr(score, key)) for score in scores], axis=0) for key in _ERRORS}
    return [FrameScore(**{key: np.where(known[key], getattr(score, key), np.nan) for key in _ERRORS}) for score in scores]


def measures_of(structure: Structure) -> list[Measure]:
    """Measures that apply to at least one part or joint of a structure."""
    return [measure for measure in MEASURES if measured_rows(measure, structure)]


def figures_of(structure: Structure) -> list[Figure[ObjectScans]]:
    """Means over all parts, or joints, of each measure that applies to a structure."""
    return [measure_figure(measure, measured_rows(measure, structure).values()) for measure in measures_of(structure)]


def summary(objects: Sequence[ObjectScans], structure: Structure) -> Estimates:
    """Means over all parts, or joints, by title of the measure, and the percentage of failed frames."""
    return summarise(objects, figures_of(structure)) | summarise(objects, [FAILED], draws=1)


def change(before: Sequence[ObjectScans], after: Sequence[ObjectScans], structure: Structure) -> Estimates:
    """Differences `after` minus `before` of the means of two rows, by title of the measure.

    Means are over the parts and joints of each frame that both found. Bootstrap samples have the same objects in both rows.
    """
    figures = figures_of(structure)
    sums = (figure_sums(objects, figures) for objects in found_by_all((before, after)))
    return by_key(figures, paired_differences(*sums))


def change_of_failed_share(before: Sequence[ObjectScans], after: Sequence[ObjectScans]) -> float | None:
    """Difference of the percentages of failed frames of two rows; None without frames."""
    first, last = (summarise(objects, [FAILED], draws=1)[FAILED.key] for objects in (before, after))
    return None if first is None or last is None else last.value - first.value


def gap_closed(
    less: Sequence[ObjectScans], more: Sequence[ObjectScans], best: Sequence[ObjectScans], structure: Structure
) -> dict[str, float | None]:
    """Shares of the gap between `less` and `best` that the row `more` closes, by title of the measure.

    They are over the parts and joints of each frame that all three found. None if `best` is not better than `less` with 95 %
    confidence.
    """
    figures = figures_of(structure)
    low, middle, high = (figure_sums(objects, figures) for objects in found_by_all((less, more, best)))
    gains, gaps = paired_differences(low, middle), paired_differences(low, high)
    shares: dict[str, float | None] = {}
    for measure, gain, gap in zip(measures_of(structure), gains, gaps, strict=True):
        is_sure = gap is not None and (gap.low > 0.0 if measure.larger_is_better else gap.high < 0.0)
        shares[measure.title] = gain.value / gap.value if is_sure and gain is not None and gap is not None else None
    return shares


def write_scores(path: Path, scores: Iterable[tuple[str, FrameScore]]) -> None:
    """Write one JSON line a frame, with the id of its object. Errors of what was not found are null."""
    lines = (json.dumps({"id": name, **{key: _plain(getattr(score, key)) for key in _ERRORS}}) + "\n" for name, score in scores)
    write_text_atomically(path, "".join(lines))


def read_scores(paths: Sequence[Path]) -> list[ObjectScans]:
    """Read the objects of files of `write_scores` in the order of their ids, each with its frames of all files.

    Raises InputError if a file cannot be read or has another form.
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
