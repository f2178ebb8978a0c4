"""What the frames of test objects come to: means with their intervals, and how far those of two rows lie apart."""

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
    """Those that a part or a joint of the structure has."""
    return [measure for measure in MEASURES if measured_rows(measure, structure)]


def measure_titles(structure: Structure) -> list[str]:
    """Titles of what `summary` gives."""
    return [measure.title for measure in measures_of(structure)]


def summary(objects: Sequence[ObjectScans], structure: Structure) -> list[Estimate | None]:
    """Means over all parts, or joints, of the measures that the structure has."""
    return micro(figure_sums(objects, _figures(structure)))


def failures(objects: Sequence[ObjectScans]) -> float | None:
    """The share of frames, in percent, in which a part was not found; None without frames."""
    (found,) = micro(figure_sums(objects, [failed_frames()]), draws=1)
    return None if found is None else found.value


def change(before: Sequence[ObjectScans], after: Sequence[ObjectScans], structure: Structure) -> list[Estimate | None]:
    """By how much the means of `after` are above those of `before`, over what both have found of the same frames.

    The objects are drawn alike for both.
    """
    figures = _figures(structure)
    return paired_differences(*(figure_sums(objects, figures) for objects in found_by_all((before, after))))


def change_of_failures(before: Sequence[ObjectScans], after: Sequence[ObjectScans]) -> float | None:
    """By how many hundredths of the frames more `after` has some part not found; None without frames."""
    shares = failures(before), failures(after)
    return None if shares[0] is None or shares[1] is None else shares[1] - shares[0]


def gap_closed(
    less: Sequence[ObjectScans], more: Sequence[ObjectScans], best: Sequence[ObjectScans], structure: Structure
) -> list[float | None]:
    """A measure each: the share of the way from the errors of `less` to those of `best` that `more` has gone.

    Over what all three have found of the same frames.
    None where `best` gains no more on `less` than chance could do: there is no way to go.
    """
    low, middle, high = (figure_sums(objects, _figures(structure)) for objects in found_by_all((less, more, best)))
    shares: list[float | None] = []
    for measure, gone, way in zip(
        measures_of(structure), paired_differences(low, middle), paired_differences(low, high), strict=True
    ):
        is_sure = way is not None and (way.low > 0.0 if measure.larger_is_better else way.high < 0.0)
        shares.append(gone.value / way.value if is_sure and gone is not None and way is not None else None)
    return shares


def _figures(structure: Structure) -> list[Figure[ObjectScans]]:
    return [measure_figure(measure, list(measured_rows(measure, structure).values())) for measure in measures_of(structure)]
