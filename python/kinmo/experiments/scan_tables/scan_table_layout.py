"""The paper's tables of partial scans (Tables 2 to 4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from kinmo.core.joint import JointKind
from kinmo.evaluation.aggregate import Estimate, figure_sums, micro
from kinmo.evaluation.paper_tables import MARK
from kinmo.evaluation.scan_records import MEASURES, Measure, ObjectScans, failed_frames, measure_figure, measured_rows
from kinmo.evaluation.tables import INTERVAL, Caption, Cell, Column, Table
from kinmo.experiments.scan_tables.scan_summary import change, change_of_failures, failures, measures_of, summary
from kinmo.scans.object_structure import Structure

NOT_RUN, OUTDATED = "not run", "outdated"
FAILED = Column("failed (%)", 1)
MAX_ROWS = 12
"""Rows of a short table."""
PaperRow = Sequence[Sequence[float | None]]
"""What the paper prints of a row: a list a measure (rotation, translation, IoU, state, axis, line), in it a value a part."""


@dataclass(frozen=True)
class ScanRow:
    """One row of a table: the objects that were judged, with networks of `seeds`, and what the paper prints there.

    `trained_on` counts the objects that networks learnt from: labelled ones, and others. `absent` says that there are no
    judged objects, if there are none, and `reason` why, where that is known.
    """

    name: str
    objects: tuple[ObjectScans, ...]
    printed: PaperRow | None = None
    seeds: tuple[int, ...] = ()
    absent: str = NOT_RUN
    trained_on: str | None = None
    reason: str | None = None


def by_part(rows: Sequence[ScanRow], structure: Structure, caption: Caption, more: Sequence[Measure] = ()) -> Table:
    """A line a part, its joint beside it, for every row, with `more` measures; the paper's figures below the row's own."""
    measures = [*measures_of(structure), *more]
    columns = (Column("trained on"), Column("part"), *(Column(m.title, m.decimals) for m in measures), FAILED)
    lines: list[tuple[Cell, ...]] = []
    for row in rows:
        if not row.objects:
            lines.append((row.name, row.absent, *([None] * (len(measures) + 1))))
        else:
            for part in range(structure.part_count):
                figures = [
                    measure_figure(m, [place]) for m in measures if (place := measured_rows(m, structure).get(part)) is not None
                ]
                found = iter(micro(figure_sums(row.objects, [*figures, failed_frames()]), draws=1))
                cells = [_value(next(found)) if part in measured_rows(m, structure) else None for m in measures]
                lines.append((row.name, str(part), *cells, _value(next(found))))
        if row.printed is not None:
            for part in range(max(map(len, row.printed))):
                lines.append((_authors(row), str(part), *_printed(row.printed, part, measures), None))
    return Table(_counted(caption, rows), columns, tuple(lines))


def over_parts(
    rows: Sequence[ScanRow], structure: Structure, caption: Caption, compared: Sequence[tuple[ScanRow, ScanRow]] = ()
) -> Table:
    """Means over all parts, or joints, with their 95 % intervals over the objects, and the share of frames that failed.

    Then by how much the second of every pair of `compared` is above the first, over what both have found.
    """
    columns = [Column("trained on"), Column("objects"), Column("seeds")]
    for measure in measures_of(structure):
        columns += [Column(measure.title, measure.decimals), INTERVAL]
    lines: list[tuple[Cell, ...]] = []
    for row in rows:
        cells: list[Cell] = [row.name, row.trained_on, _seeds(row) if row.objects else row.absent]
        lines.append((*cells, *_with_intervals(summary(row.objects, structure), structure), failures(row.objects)))
        if row.printed is not None:
            means = printed_means(row.printed)
            figures = [cell for measure in measures_of(structure) for cell in (means.get(measure), None)]
            lines.append((_authors(row), None, None, *figures, None))
    for before, after in compared:
        differences = change(before.objects, after.objects, structure)
        name = f"{after.name} against {before.name}"
        lost = change_of_failures(before.objects, after.objects)
        lines.append((name, None, _seeds(after), *_with_intervals(differences, structure), lost))
    return Table(_counted(caption, rows), (*columns, FAILED), tuple(lines))


def means_alone(rows: Sequence[ScanRow], structure: Structure, caption: Caption) -> Table:
    """Means over all parts, or joints: a short table of at most `MAX_ROWS` rows; printed figures only if they fit."""
    measures = measures_of(structure)
    columns = (Column("trained on"), *(Column(measure.title, measure.decimals) for measure in measures), FAILED)
    has_room = len(rows) + sum(row.printed is not None for row in rows) <= MAX_ROWS
    lines: list[tuple[Cell, ...]] = []
    for row in rows[:MAX_ROWS]:
        if row.objects:
            lines.append((row.name, *map(_value, summary(row.objects, structure)), failures(row.objects)))
        if row.printed is not None and has_room:
            means = printed_means(row.printed)
            lines.append((_authors(row), *(means.get(measure) for measure in measures), None))
    return Table(_counted(caption, rows), columns, tuple(lines))


def of_nothing(rows: Sequence[ScanRow], caption: Caption) -> Table:
    """A table of a category of which nothing is scanned yet, so that its structure is not known."""
    lines = ((row.name, row.absent) for row in rows)
    return Table(caption, (Column("trained on"), Column("seeds")), tuple(lines))


def over_categories(rows: Mapping[str, Mapping[str, ScanRow]], structures: Mapping[str, Structure], caption: Caption) -> Table:
    """Means over categories of their means over all parts, or joints: `rows` are by name, then by category.

    A category counts in the measures that its structure has; one that was not run, in none. What none has is no column.
    """
    had = {measure for structure in structures.values() for measure in measures_of(structure)}
    had |= {
        m for by_category in rows.values() for row in by_category.values() if row.printed for m in printed_means(row.printed)
    }
    measures = [measure for measure in MEASURES if measure in had]
    shown = (Column(measure.title, measure.decimals) for measure in measures)
    columns = (Column("trained on"), Column("categories", 0), *shown, FAILED)
    lines: list[tuple[Cell, ...]] = []
    for name, by_category in rows.items():
        run = {category: row.objects for category, row in by_category.items() if row.objects}
        values: list[dict[Measure, float]] = []
        for category, objects in run.items():
            structure = structures[category]
            found = zip(measures_of(structure), summary(objects, structure), strict=True)
            values.append({measure: estimate.value for measure, estimate in found if estimate is not None})
        lost = [share for objects in run.values() if (share := failures(objects)) is not None]
        absent = OUTDATED if any(row.absent == OUTDATED for row in by_category.values()) else NOT_RUN
        lines.append((name, len(run) or absent, *_means(values, measures), sum(lost) / len(lost) if lost else None))
        printed = [row for row in by_category.values() if row.printed is not None]
        if printed:
            own = [printed_means(row.printed) for row in printed if row.printed is not None]
            lines.append((_authors(printed[0]), len(printed), *_means(own, measures), None))
    counts = [_counted(caption, [by_category[category] for by_category in rows.values()]) for category in structures]
    whole = replace(caption, shapes=sum(one.shapes for one in counts), scans=sum(one.scans for one in counts))
    return Table(whole, columns, tuple(lines))


def _means(values: Sequence[Mapping[Measure, float]], measures: Sequence[Measure]) -> list[Cell]:
    """Of each of the measures, over those that have it."""
    known = [[some[measure] for some in values if measure in some] for measure in measures]
    return [sum(some) / len(some) if some else None for some in known]


def _value(estimate: Estimate | None) -> float | None:
    return None if estimate is None else estimate.value


def _seeds(row: ScanRow) -> str:
    return ", ".join(map(str, row.seeds))


def _with_intervals(estimates: Sequence[Estimate | None], structure: Structure) -> list[Cell]:
    cells: list[Cell] = []
    for measure, found in zip(measures_of(structure), estimates, strict=True):
        cells += [_value(found), None if found is None else found.interval(measure.decimals)]
    return cells


PAPER_COLUMNS: Mapping[str, int] = {"rotation": 0, "translation": 1, "iou": 2, "state": 3, "axis": 4, "line": 5}


def _printed(row: PaperRow, part: int, measures: Sequence[Measure]) -> list[Cell]:
    """What the paper prints of a part, or of its joint; None for what the part has not there, whatever ours has."""
    structure = printed_structure(row)
    cells: list[Cell] = []
    for measure in measures:
        values = row[PAPER_COLUMNS[measure.key]] if measure.key in PAPER_COLUMNS else ()
        place = part - 1 if measure.per_joint else part
        cells.append(values[place] if part in measured_rows(measure, structure) and place < len(values) else None)
    return cells


def printed_structure(printed: PaperRow) -> Structure:
    """What the paper must have printed a row of: joints that it has distances of lines of turn, the others slide."""
    lines = len(printed[PAPER_COLUMNS["line"]])
    joints = len(printed[PAPER_COLUMNS["axis"]])
    kinds = tuple(JointKind.REVOLUTE if joint < lines else JointKind.PRISMATIC for joint in range(joints))
    return Structure(kinds, (0,) * joints)


def printed_means(printed: PaperRow) -> dict[Measure, float]:
    """Means over all parts, or joints, of what the paper prints in a row; without measures that it has no figures of."""
    structure = printed_structure(printed)
    measures = measures_of(structure)
    rows = [_printed(printed, part, measures) for part in range(structure.part_count)]
    found = {}
    for measure, column in zip(measures, zip(*rows, strict=True), strict=True):
        known = [float(value) for value in column if isinstance(value, float | int)]
        if known:
            found[measure] = sum(known) / len(known)
    return found


def _authors(row: ScanRow) -> str:
    return f"{row.name}, {MARK}"


def _counted(caption: Caption, rows: Sequence[ScanRow]) -> Caption:
    most = max((row.objects for row in rows), key=len, default=())
    return replace(caption, shapes=len(most), scans=sum(len(scored.frames) for scored in most))
