"""Means over the test scans of a table row with their intervals, and differences between rows."""

from __future__ import annotations

from collections.abc import Sequence

from kinmo.evaluation.aggregate import Estimate, Figure, figure_sums, micro, paired_differences
from kinmo.evaluation.scan_records import (
    MEASURES,
    Measure,
    ObjectScans,
    failed_frames,
    found_by_all,
    measure_figure,
    measured_rows,
)
from kinmo.scans.object_structure import Structure


def measures_of(structure: Structure) -> list[Measure]:
    """Measures that apply to at least one part or joint of a structure."""
    return [measure for measure in MEASURES if measured_rows(measure, structure)]


def measure_titles(structure: Structure) -> list[str]:
    """Titles of the values that `summary` returns."""
    return [measure.title for measure in measures_of(structure)]


def summary(objects: Sequence[ObjectScans], structure: Structure) -> list[Estimate | None]:
    """Means over all parts, or joints, of each measure that applies to the structure."""
    return micro(figure_sums(objects, _figures(structure)))


def failed_share(objects: Sequence[ObjectScans]) -> float | None:
    """Percentage of the frames in which a part was not found; None without frames."""
    (found,) = micro(figure_sums(objects, [failed_frames()]), draws=1)
    return None if found is None else found.value


def change(before: Sequence[ObjectScans], after: Sequence[ObjectScans], structure: Structure) -> list[Estimate | None]:
    """Differences of the means of two rows, over the parts and joints of each frame that both found.

    Args:
        before: Scores of one row.
        after: Scores of the other row.
        structure: Structure of the objects.

    Returns:
        `after` minus `before` for each measure that applies. Bootstrap samples have the same objects in both rows.
    """
    figures = _figures(structure)
    return paired_differences(*(figure_sums(objects, figures) for objects in found_by_all((before, after))))


def change_of_failed_share(before: Sequence[ObjectScans], after: Sequence[ObjectScans]) -> float | None:
    """Difference of the failed shares of two rows in percentage points; None without frames."""
    shares = failed_share(before), failed_share(after)
    return None if shares[0] is None or shares[1] is None else shares[1] - shares[0]


def gap_closed(
    less: Sequence[ObjectScans], more: Sequence[ObjectScans], best: Sequence[ObjectScans], structure: Structure
) -> list[float | None]:
    """Share of the gap between two rows that a third row closes, over the parts and joints of each frame that all three found.

    Args:
        less: Scores at the worse end of the gap.
        more: Scores of the row in between.
        best: Scores at the better end of the gap.
        structure: Structure of the objects.

    Returns:
        The share for each measure that applies; None if `best` is not better than `less` with 95 % confidence.
    """
    low, middle, high = (figure_sums(objects, _figures(structure)) for objects in found_by_all((less, more, best)))
    shares: list[float | None] = []
    for measure, gain, gap in zip(
        measures_of(structure), paired_differences(low, middle), paired_differences(low, high), strict=True
    ):
        is_sure = gap is not None and (gap.low > 0.0 if measure.larger_is_better else gap.high < 0.0)
        shares.append(gain.value / gap.value if is_sure and gain is not None and gap is not None else None)
    return shares


def _figures(structure: Structure) -> list[Figure[ObjectScans]]:
    return [measure_figure(measure, list(measured_rows(measure, structure).values())) for measure in measures_of(structure)]
