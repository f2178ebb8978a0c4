"""Layout of the tables of partial scans (paper, Tables 2 to 4): rows of scores become tables of text and numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from kinmo.core.joint import JointKind
from kinmo.evaluation import scan_records
from kinmo.evaluation.aggregate import Estimate, Estimates, summarise
from kinmo.evaluation.paper_tables import MARK, mean
from kinmo.evaluation.scan_records import FAILED, MEASURES, Measure, ObjectScans, measure_figure, measured_rows, measures_of
from kinmo.evaluation.tables import INTERVAL, Caption, Column, Table, Values
from kinmo.scans.object_structure import Structure

NOT_RUN, OUTDATED = "not run", "outdated"
Figures = Mapping[str, Estimate | float | None]  # figures of a row by title of the measure
NAME = "trained on"  # title of the column with the names of the rows
MAX_ROWS = 12  # rows of the summary at most
PaperRow = Sequence[Sequence[float | None]]
"""Printed figures of a row: one list for each of rotation, translation, IoU, state, axis and line, with one value per part."""
PAPER_COLUMNS: Mapping[str, int] = {"rotation": 0, "translation": 1, "iou": 2, "state": 3, "axis": 4, "line": 5}
"""Place of each measure in a `PaperRow`, by the key of the measure."""


@dataclass(frozen=True)
class ScanRow:
    """One row of a table, with the scores of the test objects of all seeds, and the figures that the paper prints there.

    `absent` stands in place of missing scores, `reason` says why they are missing, if it is known. `trained_on` are the numbers
    of labelled training objects, and of others.
    """

    name: str
    objects: tuple[ObjectScans, ...]
    printed: PaperRow | None = None
    seeds: tuple[int, ...] = ()
    absent: str = NOT_RUN
    trained_on: str | None = None
    reason: str | None = None

    @property
    def authors_name(self) -> str:
        """Title of the printed figures."""
        return f"{self.name}, {MARK}"

    @property
    def seeds_in_words(self) -> str:
        """The seeds, or the text in place of missing scores."""
        return ", ".join(map(str, self.seeds)) if self.objects else self.absent


def by_part(rows: Sequence[ScanRow], structure: Structure, caption: Caption, more: Sequence[Measure] = ()) -> Table:
    """Table with one line for each part of each row; a joint stands beside the part that it moves.

    Printed figures follow below the lines of their row. `more` are measures beside the usual ones.
    """
    measures = [*measures_of(structure), *more]
    lines: list[Values] = []
    for row in rows:
        if row.objects:
            lines += [
                {NAME: row.name, "part": str(part), **_part_means(row.objects, part, structure, measures)}
                for part in range(structure.part_count)
            ]
        else:
            lines.append({NAME: row.name, "part": row.absent})
        if row.printed is not None:
            lines += [
                {NAME: row.authors_name, "part": str(part), **_printed_figures(row.printed, part)}
                for part in range(max(map(len, row.printed)))
            ]
    return _table(_with_counts(caption, rows), (Column("part"),), measures, lines)


def _part_means(objects: Sequence[ObjectScans], part: int, structure: Structure, measures: Sequence[Measure]) -> Estimates:
    """Means of the measures that a part has, and the share of failed frames."""
    places = [(measure, measured_rows(measure, structure)) for measure in measures]
    figures = [*(measure_figure(measure, [place[part]]) for measure, place in places if part in place), FAILED]
    return summarise(objects, figures, draws=1)


def over_parts(
    rows: Sequence[ScanRow], structure: Structure, caption: Caption, compared: Sequence[Sequence[ScanRow]] = ()
) -> Table:
    """Table of means over all parts, or joints, with 95 % intervals over objects, and shares of failed frames.

    Printed figures follow below their row. Lines at the end show the difference of the second to the first row of each pair in
    `compared` (`scan_records.change`).
    """
    lines: list[Values] = []
    for row in rows:
        words = {NAME: row.name, "objects": row.trained_on, "seeds": row.seeds_in_words}
        lines.append({**words, **scan_records.summary(row.objects, structure)})
        if row.printed is not None:
            lines.append({NAME: row.authors_name, **printed_means(row.printed)})
    for before, after in compared:
        words = {NAME: f"{after.name} against {before.name}", "seeds": after.seeds_in_words}
        failed = scan_records.change_of_failed_share(before.objects, after.objects)
        lines.append({**words, **scan_records.change(before.objects, after.objects, structure), FAILED.title: failed})
    columns = (Column("objects"), Column("seeds"))
    return _table(_with_counts(caption, rows), columns, measures_of(structure), lines, has_intervals=True)


def means_alone(rows: Sequence[ScanRow], structure: Structure, caption: Caption) -> Table:
    """Short table of means over all parts, or joints, of at most `MAX_ROWS` rows; printed figures are there if they fit."""
    has_room = len(rows) + sum(row.printed is not None for row in rows) <= MAX_ROWS
    lines: list[Values] = []
    for row in rows[:MAX_ROWS]:
        if row.objects:
            lines.append({NAME: row.name, **scan_records.summary(row.objects, structure)})
        if row.printed is not None and has_room:
            lines.append({NAME: row.authors_name, **printed_means(row.printed)})
    return _table(_with_counts(caption, rows), (), measures_of(structure), lines)


def without_structure(rows: Sequence[ScanRow], caption: Caption) -> Table:
    """Table of a category without scans and without printed figures: its structure is unknown."""
    return Table(caption, (Column(NAME), Column("seeds")), tuple((row.name, row.absent) for row in rows))


def over_categories(rows: Mapping[str, Mapping[str, ScanRow]], structures: Mapping[str, Structure], caption: Caption) -> Table:
    """Table of means over categories of their means over all parts, or joints, from rows by title, then by category.

    A category counts in the measures that apply to its structure; those without scans have none. Rows without scores do not
    count.
    """
    lines: list[Values] = []
    for title, by_category in rows.items():
        scored = [scan_records.summary(row.objects, structures[name]) for name, row in by_category.items() if row.objects]
        absent = OUTDATED if any(row.absent == OUTDATED for row in by_category.values()) else NOT_RUN
        lines.append({NAME: title, "categories": len(scored) or absent, **_means_of(scored)})
        printed = [printed_means(row.printed) for row in by_category.values() if row.printed is not None]
        if printed:
            lines.append({NAME: f"{title}, {MARK}", "categories": len(printed), **_means_of(printed)})
    printed_rows = [row.printed for own in rows.values() for row in own.values() if row.printed is not None]
    titles = {measure.title for structure in structures.values() for measure in measures_of(structure)}
    titles |= {title for printed in printed_rows for title in printed_means(printed)}
    measures = [measure for measure in MEASURES if measure.title in titles]
    captions = [_with_counts(caption, [by_category[category] for by_category in rows.values()]) for category in structures]
    whole = replace(caption, shapes=sum(own.shapes for own in captions), scans=sum(own.scans for own in captions))
    return _table(whole, (Column("categories", 0),), measures, lines)


def _table(
    caption: Caption, more: Sequence[Column], measures: Sequence[Measure], lines: Sequence[Values], has_intervals: bool = False
) -> Table:
    """Table with columns of names, of `more`, of measures, and of failed frames."""
    columns = [Column(NAME), *more]
    for measure in measures:
        columns += [Column(measure.title, measure.decimals), *([INTERVAL] if has_intervals else [])]
    return Table.of(caption, [*columns, Column(FAILED.title, 1)], lines)


def _means_of(rows: Sequence[Figures]) -> dict[str, float]:
    """Means of figures over the rows that have them; figures that none has are left out."""
    values = [{title: found.value if isinstance(found, Estimate) else found for title, found in row.items()} for row in rows]
    means = {title: mean([row.get(title) for row in values]) for row in values for title in row}
    return {title: value for title, value in means.items() if value is not None}


def _printed_figures(printed: PaperRow, part: int) -> dict[str, float | None]:
    """Printed figures of a part, or of its joint, by title of the measure."""
    structure, found = printed_structure(printed), {}
    for measure in measures_of(structure):
        figures, place = printed[PAPER_COLUMNS[measure.key]], measured_rows(measure, structure).get(part)
        if place is not None and place < len(figures):
            found[measure.title] = figures[place]
    return found


def printed_structure(printed: PaperRow) -> Structure:
    """Structure of the objects behind a printed row: joints with a line distance are hinges, the others are sliders."""
    lines = len(printed[PAPER_COLUMNS["line"]])
    joints = len(printed[PAPER_COLUMNS["axis"]])
    kinds = tuple(JointKind.REVOLUTE if joint < lines else JointKind.PRISMATIC for joint in range(joints))
    return Structure(kinds, (0,) * joints)


def printed_means(printed: PaperRow) -> dict[str, float]:
    """Means of printed figures over all parts, or joints, by title of the measure."""
    return _means_of([_printed_figures(printed, part) for part in range(printed_structure(printed).part_count)])


def _with_counts(caption: Caption, rows: Sequence[ScanRow]) -> Caption:
    """The caption with the numbers of test objects and scans of the row that has most."""
    most = max((row.objects for row in rows), key=len, default=())
    return replace(caption, shapes=len(most), scans=sum(len(scored.frames) for scored in most))
