"""The paper's tables of partial scans (Tables 2 to 4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from kinmo.evaluation.aggregate import Estimate, micro, sums_of
from kinmo.evaluation.paper_tables import MARK
from kinmo.evaluation.scan_records import MEASURES, Measure, ObjectScans, failed, of_rows, rows_of
from kinmo.evaluation.tables import Caption, Cell, Column, Table
from kinmo.joint import JointKind
from kinmo.scans.articulated_object import Structure

NOT_RUN, OUTDATED = "not run", "outdated"
FAILED = Column("failed (%)", 1)
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


def by_part(rows: Sequence[ScanRow], structure: Structure, caption: Caption) -> Table:
    """A line a part, its joint beside it, for every row; the paper's figures below the row's own."""
    measures = _measures(structure)
    columns = (Column("trained on"), Column("part"), *(Column(m.title, m.decimals) for m in measures), FAILED)
    lines: list[tuple[Cell, ...]] = []
    for row in rows:
        if not row.objects:
            lines.append((row.name, row.absent, *([None] * (len(measures) + 1))))
        else:
            for part in range(structure.part_count):
                figures = [of_rows(m, [place]) for m in measures if (place := rows_of(m, structure).get(part)) is not None]
                found = iter(micro(sums_of(row.objects, [*figures, failed()]), draws=1))
                cells = [_value(next(found)) if part in rows_of(m, structure) else None for m in measures]
                lines.append((row.name, str(part), *cells, _value(next(found))))
        if row.printed is not None:
            for part in range(max(map(len, row.printed))):
                lines.append((_authors(row), str(part), *_printed(row.printed, part, measures, structure), None))
    return Table(_counted(caption, rows), columns, tuple(lines))


def over_parts(rows: Sequence[ScanRow], structure: Structure, caption: Caption) -> Table:
    """Means over all parts, or joints, with their 95 % intervals over the objects, and the share of frames that failed."""
    columns = [Column("trained on"), Column("objects"), Column("seeds")]
    for measure in _measures(structure):
        columns += [Column(measure.title, measure.decimals), Column("95 %")]
    lines: list[tuple[Cell, ...]] = []
    for row in rows:
        cells: list[Cell] = [row.name, row.trained_on, ", ".join(map(str, row.seeds)) if row.objects else row.absent]
        for measure, estimate in zip(_measures(structure), summary(row.objects, structure), strict=True):
            cells += [_value(estimate), _interval(estimate, measure.decimals)]
        lines.append((*cells, failures(row.objects)))
        if row.printed is not None:
            means = printed_means(row.printed, structure)
            figures = [cell for measure in _measures(structure) for cell in (means.get(measure), None)]
            lines.append((_authors(row), None, None, *figures, None))
    return Table(_counted(caption, rows), (*columns, FAILED), tuple(lines))


def of_nothing(rows: Sequence[ScanRow], caption: Caption) -> Table:
    """A table of a category of which nothing is scanned yet, so that its structure is not known."""
    lines = ((row.name, row.absent) for row in rows)
    return Table(caption, (Column("trained on"), Column("seeds")), tuple(lines))


def over_categories(rows: Mapping[str, Mapping[str, ScanRow]], structures: Mapping[str, Structure], caption: Caption) -> Table:
    """Means over categories of their means over all parts, or joints: `rows` are by name, then by category.

    A category counts in the measures that its structure has; one that was not run, in none.
    """
    columns = (
        Column("trained on"),
        Column("categories", 0),
        *(Column(measure.title, measure.decimals) for measure in MEASURES),
        FAILED,
    )
    lines: list[tuple[Cell, ...]] = []
    for name, by_category in rows.items():
        run = {category: row.objects for category, row in by_category.items() if row.objects}
        values: list[dict[Measure, float]] = []
        for category, objects in run.items():
            structure = structures[category]
            found = zip(_measures(structure), summary(objects, structure), strict=True)
            values.append({measure: estimate.value for measure, estimate in found if estimate is not None})
        lost = [share for objects in run.values() if (share := failures(objects)) is not None]
        lines.append((name, len(run) or NOT_RUN, *_means(values), sum(lost) / len(lost) if lost else None))
        printed = [row for row in by_category.values() if row.printed is not None]
        if printed:
            own = [printed_means(row.printed, printed_structure(row.printed)) for row in printed if row.printed is not None]
            lines.append((_authors(printed[0]), len(printed), *_means(own), None))
    return Table(caption, columns, tuple(lines))


def _means(values: Sequence[Mapping[Measure, float]]) -> list[Cell]:
    """Of every measure, over those that have it."""
    known = [[some[measure] for some in values if measure in some] for measure in MEASURES]
    return [sum(some) / len(some) if some else None for some in known]


def gap_closed(
    less: Sequence[ObjectScans], more: Sequence[ObjectScans], best: Sequence[ObjectScans], structure: Structure
) -> list[float | None]:
    """A measure each: the share of the way from the errors of `less` to those of `best` that `more` has gone.

    None where `best` is no better than `less`: there is no way to go.
    """
    shares: list[float | None] = []
    rows = (summary(objects, structure) for objects in (less, more, best))
    for measure, low, mid, high in zip(_measures(structure), *rows, strict=True):
        way = 0.0 if low is None or high is None else high.value - low.value
        is_better = way > 0.0 if measure.larger_is_better else way < 0.0
        shares.append((mid.value - low.value) / way if is_better and low is not None and mid is not None else None)
    return shares


def summary(objects: Sequence[ObjectScans], structure: Structure) -> list[Estimate | None]:
    """Means over all parts, or joints, of the measures that the structure has."""
    figures = [of_rows(measure, list(rows_of(measure, structure).values())) for measure in _measures(structure)]
    return micro(sums_of(objects, figures))


def failures(objects: Sequence[ObjectScans]) -> float | None:
    """The share of frames, in percent, in which a part was not found; None without frames."""
    (found,) = micro(sums_of(objects, [failed()]), draws=1)
    return _value(found)


def measure_titles(structure: Structure) -> list[str]:
    """Titles of what `summary` gives."""
    return [measure.title for measure in _measures(structure)]


def _measures(structure: Structure) -> list[Measure]:
    return [measure for measure in MEASURES if rows_of(measure, structure)]


def _value(estimate: Estimate | None) -> float | None:
    return None if estimate is None else estimate.value


def _interval(estimate: Estimate | None, decimals: int) -> Cell:
    return None if estimate is None else f"{estimate.low:.{decimals}f} to {estimate.high:.{decimals}f}"


PAPER_COLUMNS: Mapping[str, int] = {"rotation": 0, "translation": 1, "iou": 2, "state": 3, "axis": 4, "line": 5}


def _printed(row: PaperRow, part: int, measures: Sequence[Measure], structure: Structure) -> list[Cell]:
    cells: list[Cell] = []
    for measure in measures:
        values = row[PAPER_COLUMNS[measure.key]]
        place = part - 1 if measure.of_joints else part
        fits = part in rows_of(measure, structure) and 0 <= place < len(values)
        cells.append(values[place] if fits else None)
    return cells


def printed_structure(printed: PaperRow) -> Structure:
    """What the paper must have printed a row of: joints that it has distances of lines of turn, the others slide."""
    lines = len(printed[PAPER_COLUMNS["line"]])
    joints = len(printed[PAPER_COLUMNS["axis"]])
    kinds = tuple(JointKind.REVOLUTE if joint < lines else JointKind.PRISMATIC for joint in range(joints))
    return Structure(kinds, (0,) * joints)


def printed_means(printed: PaperRow, structure: Structure) -> dict[Measure, float]:
    """Means over all parts, or joints, of what the paper prints in a row; without measures that it has no figures of."""
    measures = _measures(structure)
    rows = [_printed(printed, part, measures, structure) for part in range(structure.part_count)]
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
