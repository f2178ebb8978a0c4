"""Layout of the tables of partial scans (paper, Tables 2 to 4): rows of scores become tables of text and numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from kinmo.core.joint import JointKind
from kinmo.evaluation.aggregate import Estimate, figure_sums, micro
from kinmo.evaluation.paper_tables import MARK, mean
from kinmo.evaluation.scan_records import MEASURES, Measure, ObjectScans, failed_frames, measure_figure, measured_rows
from kinmo.evaluation.tables import INTERVAL, Caption, Cell, Column, Table
from kinmo.experiments.scan_tables.scan_summary import change, change_of_failed_share, failed_share, measures_of, summary
from kinmo.scans.object_structure import Structure

NOT_RUN, OUTDATED = "not run", "outdated"
FAILED = Column("failed (%)", 1)
MAX_ROWS = 12
"""Rows of the summary at most."""
PaperRow = Sequence[Sequence[float | None]]
"""Printed figures of a row: one list for each of rotation, translation, IoU, state, axis and line, with one value per part."""
PAPER_COLUMNS: Mapping[str, int] = {"rotation": 0, "translation": 1, "iou": 2, "state": 3, "axis": 4, "line": 5}
"""Place of each measure in a `PaperRow`, by the key of the measure."""


@dataclass(frozen=True)
class ScanRow:
    """One row of a table, with its scores and the figures that the paper prints there.

    Attributes:
        name: Title of the row.
        objects: Scores of the test objects, of all seeds.
        printed: Printed figures; None if there are none.
        seeds: Seeds of the scored networks.
        absent: Text in place of missing scores.
        trained_on: Number of labelled training objects, and of others.
        reason: Reason why scores are missing; None if it is not known.
    """

    name: str
    objects: tuple[ObjectScans, ...]
    printed: PaperRow | None = None
    seeds: tuple[int, ...] = ()
    absent: str = NOT_RUN
    trained_on: str | None = None
    reason: str | None = None


def by_part(rows: Sequence[ScanRow], structure: Structure, caption: Caption, more: Sequence[Measure] = ()) -> Table:
    """Table with one line for each part of each row; a joint stands beside the part that it moves.

    Args:
        rows: The rows. Printed figures follow below the lines of their row.
        structure: Structure of the test objects.
        caption: Caption of the table; numbers of objects and scans are filled in.
        more: Measures beside the usual ones.
    """
    measures = [*measures_of(structure), *more]
    columns = (Column("trained on"), Column("part"), *_measure_columns(measures), FAILED)
    lines: list[tuple[Cell, ...]] = []
    for row in rows:
        if row.objects:
            for part in range(structure.part_count):
                lines.append((row.name, str(part), *_part_cells(row, part, structure, measures)))
        else:
            lines.append((row.name, row.absent, *([None] * (len(measures) + 1))))
        if row.printed is not None:
            for part in range(max(map(len, row.printed))):
                lines.append((_authors_title(row), str(part), *_printed_cells(row.printed, part, measures), None))
    return Table(_with_counts(caption, rows), columns, tuple(lines))


def _part_cells(row: ScanRow, part: int, structure: Structure, measures: Sequence[Measure]) -> list[Cell]:
    """Cells of one part: its measures, None where it has none, and the share of failed frames."""
    places = [measured_rows(measure, structure).get(part) for measure in measures]
    figures = [measure_figure(measure, [place]) for measure, place in zip(measures, places, strict=True) if place is not None]
    found = iter(micro(figure_sums(row.objects, [*figures, failed_frames()]), draws=1))
    return [*(None if place is None else _value(next(found)) for place in places), _value(next(found))]


def over_parts(
    rows: Sequence[ScanRow], structure: Structure, caption: Caption, compared: Sequence[tuple[ScanRow, ScanRow]] = ()
) -> Table:
    """Table of means over all parts, or joints, with 95 % intervals over objects, and shares of failed frames.

    Args:
        rows: The rows. Printed figures follow below their row.
        structure: Structure of the test objects.
        caption: Caption of the table; numbers of objects and scans are filled in.
        compared: Pairs of rows; lines below the rows show the difference of the second to the first (`scan_summary.change`).
    """
    columns = [Column("trained on"), Column("objects"), Column("seeds")]
    for column in _measure_columns(measures_of(structure)):
        columns += [column, INTERVAL]
    lines: list[tuple[Cell, ...]] = []
    for row in rows:
        start: list[Cell] = [row.name, row.trained_on, _seeds(row) if row.objects else row.absent]
        lines.append((*start, *_with_intervals(summary(row.objects, structure), structure), failed_share(row.objects)))
        if row.printed is not None:
            means = printed_means(row.printed)
            figures = [cell for measure in measures_of(structure) for cell in (means.get(measure), None)]
            lines.append((_authors_title(row), None, None, *figures, None))
    for before, after in compared:
        differences = change(before.objects, after.objects, structure)
        name = f"{after.name} against {before.name}"
        failed = change_of_failed_share(before.objects, after.objects)
        lines.append((name, None, _seeds(after), *_with_intervals(differences, structure), failed))
    return Table(_with_counts(caption, rows), (*columns, FAILED), tuple(lines))


def means_alone(rows: Sequence[ScanRow], structure: Structure, caption: Caption) -> Table:
    """Short table of means over all parts, or joints, of at most `MAX_ROWS` rows; printed figures are there if they fit."""
    measures = measures_of(structure)
    columns = (Column("trained on"), *_measure_columns(measures), FAILED)
    has_room = len(rows) + sum(row.printed is not None for row in rows) <= MAX_ROWS
    lines: list[tuple[Cell, ...]] = []
    for row in rows[:MAX_ROWS]:
        if row.objects:
            lines.append((row.name, *map(_value, summary(row.objects, structure)), failed_share(row.objects)))
        if row.printed is not None and has_room:
            means = printed_means(row.printed)
            lines.append((_authors_title(row), *(means.get(measure) for measure in measures), None))
    return Table(_with_counts(caption, rows), columns, tuple(lines))


def without_structure(rows: Sequence[ScanRow], caption: Caption) -> Table:
    """Table of a category without scans and without printed figures: its structure is unknown."""
    lines = ((row.name, row.absent) for row in rows)
    return Table(caption, (Column("trained on"), Column("seeds")), tuple(lines))


def over_categories(rows: Mapping[str, Mapping[str, ScanRow]], structures: Mapping[str, Structure], caption: Caption) -> Table:
    """Table of means over categories of their means over all parts, or joints.

    A category counts in the measures that apply to its structure. Rows without scores do not count.

    Args:
        rows: Rows by title, then by category.
        structures: Structures by category; categories without scans have none.
        caption: Caption of the table; numbers of objects and scans are filled in.
    """
    printed_rows = [row.printed for own in rows.values() for row in own.values() if row.printed is not None]
    had = {measure for structure in structures.values() for measure in measures_of(structure)}
    had |= {measure for printed in printed_rows for measure in printed_means(printed)}
    measures = [measure for measure in MEASURES if measure in had]
    columns = (Column("trained on"), Column("categories", 0), *_measure_columns(measures), FAILED)
    lines: list[tuple[Cell, ...]] = []
    for title, by_category in rows.items():
        scored = {category: row.objects for category, row in by_category.items() if row.objects}
        values: list[dict[Measure, float]] = []
        for category, objects in scored.items():
            found = zip(measures_of(structures[category]), summary(objects, structures[category]), strict=True)
            values.append({measure: estimate.value for measure, estimate in found if estimate is not None})
        failed = mean([failed_share(objects) for objects in scored.values()])
        absent = OUTDATED if any(row.absent == OUTDATED for row in by_category.values()) else NOT_RUN
        lines.append((title, len(scored) or absent, *_means(values, measures), failed))
        printed = [printed_means(row.printed) for row in by_category.values() if row.printed is not None]
        if printed:
            lines.append((f"{title}, {MARK}", len(printed), *_means(printed, measures), None))
    captions = [_with_counts(caption, [by_category[category] for by_category in rows.values()]) for category in structures]
    whole = replace(caption, shapes=sum(own.shapes for own in captions), scans=sum(own.scans for own in captions))
    return Table(whole, columns, tuple(lines))


def _measure_columns(measures: Sequence[Measure]) -> list[Column]:
    return [Column(measure.title, measure.decimals) for measure in measures]


def _means(values: Sequence[Mapping[Measure, float]], measures: Sequence[Measure]) -> list[Cell]:
    """Mean of each measure over the categories that have it."""
    return [mean([own.get(measure) for own in values]) for measure in measures]


def _value(estimate: Estimate | None) -> float | None:
    return None if estimate is None else estimate.value


def _seeds(row: ScanRow) -> str:
    return ", ".join(map(str, row.seeds))


def _with_intervals(estimates: Sequence[Estimate | None], structure: Structure) -> list[Cell]:
    cells: list[Cell] = []
    for measure, found in zip(measures_of(structure), estimates, strict=True):
        cells += [_value(found), None if found is None else found.interval(measure.decimals)]
    return cells


def _printed_cells(row: PaperRow, part: int, measures: Sequence[Measure]) -> list[Cell]:
    """Printed figures of a part, or of its joint; None for a measure that the paper's part does not have."""
    structure = printed_structure(row)
    cells: list[Cell] = []
    for measure in measures:
        values = row[PAPER_COLUMNS[measure.key]] if measure.key in PAPER_COLUMNS else ()
        place = part - 1 if measure.per_joint else part
        cells.append(values[place] if part in measured_rows(measure, structure) and place < len(values) else None)
    return cells


def printed_structure(printed: PaperRow) -> Structure:
    """Structure of the objects behind a printed row: joints with a line distance are hinges, the others are sliders."""
    lines = len(printed[PAPER_COLUMNS["line"]])
    joints = len(printed[PAPER_COLUMNS["axis"]])
    kinds = tuple(JointKind.REVOLUTE if joint < lines else JointKind.PRISMATIC for joint in range(joints))
    return Structure(kinds, (0,) * joints)


def printed_means(printed: PaperRow) -> dict[Measure, float]:
    """Means of printed figures over all parts, or joints; measures without figures are left out."""
    structure = printed_structure(printed)
    measures = measures_of(structure)
    lines = [_printed_cells(printed, part, measures) for part in range(structure.part_count)]
    found = {}
    for measure, column in zip(measures, zip(*lines, strict=True), strict=True):
        known = [float(value) for value in column if isinstance(value, float | int)]
        if known:
            found[measure] = sum(known) / len(known)
    return found


def _authors_title(row: ScanRow) -> str:
    return f"{row.name}, {MARK}"


def _with_counts(caption: Caption, rows: Sequence[ScanRow]) -> Caption:
    """The caption with the numbers of test objects and scans of the row that has most."""
    most = max((row.objects for row in rows), key=len, default=())
    return replace(caption, shapes=len(most), scans=sum(len(scored.frames) for scored in most))
