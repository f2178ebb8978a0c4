"""The paper's Table 1, and the tables of rows that belong beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from kinmo.core.categories import canonical_category
from kinmo.evaluation.aggregate import Estimate, Unit
from kinmo.evaluation.joint_records import ShapeScore
from kinmo.evaluation.paper_tables import MARK, METHODS, table1_figures, table1_means
from kinmo.evaluation.summary import FIGURE, LEAST_OBJECTS, Estimates, Summary, summarise, without_controls
from kinmo.evaluation.tables import INTERVAL, Caption, Cell, Column, Table


@dataclass(frozen=True, eq=False)
class Scores:
    """The scores of one method, which are summarised once for all tables."""

    shapes: Sequence[ShapeScore]

    @cached_property
    def summary(self) -> Summary:
        return summarise(self.shapes)

    @cached_property
    def without_controls(self) -> Scores:
        """Those of all but buttons, knobs and switches."""
        return Scores(without_controls(self.shapes))


Rows = Mapping[str, Scores]
"""The scores of every method (row of a table) by its name."""

DECIMALS = {Unit.SHARE: 3, Unit.DEGREES: 2, Unit.DIAGONALS: 3, Unit.LENGTH: 3}
PAPER_MEASURE = {"axis": "angle", "raw_line": "distance"}
"""The figures that the paper prints: its distances are in the files' lengths."""

OVERVIEW = ("ok", "coarse_type", "fine_type", "missed", "axis", "typed_axis", "axis_ok", "placed_ok", "hinge_within_10")
DISTANCES = ("line", "line_at_part", "pivot", "range_iou", "penetration")
GROUPING = ("precision", "recall", "f1", "parent", "edge_type")


def caption_for(scores: Sequence[ShapeScore], caption: Caption) -> Caption:
    """The caption with the counts of the given scores."""
    joints = {(record.shape_id, record.body) for score in scores for record in score.records}
    return replace(caption, shapes=len({score.shape_id for score in scores}), joints=len(joints))


def by_category(methods: Rows, figure: str, caption: Caption, *, whole: bool = True) -> Table:
    """One figure of every method a category, with means, beside the paper's where it prints the figure.

    If it is the `whole` table, a category that only the paper has keeps its row: what was not run is to be seen; else there are
    the rows of what was run alone, and no means over categories. The counts of the caption are filled in.
    """
    summaries = {name: scores.summary for name, scores in methods.items()}
    paper = table1_figures(PAPER_MEASURE[figure]) if figure in PAPER_MEASURE else {}
    decimals = DECIMALS[FIGURE[figure].unit]
    columns = [Column("category"), Column("objects", 0), Column("joints", 0), *(Column(name, decimals) for name in summaries)]
    columns += [Column(f"{name} ({MARK})", decimals) for name in METHODS] if paper else []
    spellings = {canonical_category(name): name for summary in summaries.values() for name in summary.categories}
    rows: list[tuple[Cell, ...]] = []
    for category in sorted({*spellings, *paper} if whole else spellings):
        found = {name: summary.categories.get(spellings.get(category, "")) for name, summary in summaries.items()}
        first = next(filter(None, found.values()), None)
        figures = (None if group is None else _value(group.micro, figure) for group in found.values())
        counts = (0, 0) if first is None else (first.objects, first.joints)
        rows.append((category, *counts, *figures, *(paper.get(category, (None,) * len(METHODS)) if paper else ())))
    means = table1_means(PAPER_MEASURE[figure]) if paper else ()
    rows += _mean_rows(summaries, figure, means, whole)
    return Table(caption_for(_most(methods), caption), tuple(columns), tuple(rows))


def _mean_rows(
    summaries: Mapping[str, Summary], figure: str, paper: tuple[float | None, ...], whole: bool
) -> list[tuple[Cell, ...]]:
    absent = (None,) * len(paper)
    rows: list[tuple[Cell, ...]] = []
    for least in LEAST_OBJECTS if whole else ():
        values = [summary.macro[least].get(figure) for summary in summaries.values()]
        counts = [value.count for value in values if value is not None]
        title = f"mean of {max(counts, default=0)} categories with >= {least} objects"
        rows.append((title, None, None, *map(_plain, values), *absent))
    rows.append(("mean of joints", None, None, *(_value(summary.micro, figure) for summary in summaries.values()), *absent))
    if paper and whole:
        rows.append(("mean of the paper's categories", None, None, *([None] * len(summaries)), *paper))
    if figure in ("axis", "line"):
        medians = (summary.medians[figure] for summary in summaries.values())
        rows.append(("median of joints", None, None, *medians, *absent))
    return rows


def overview(
    methods: Rows, caption: Caption, *, figures: Sequence[str] = OVERVIEW, controls: bool = True, macro_over: int | None = None
) -> Table:
    """One row a method, one column a figure; shares count all true joints, misses as failures.

    Means are over joints, or over categories with at least `macro_over` objects. Without `controls` buttons, knobs and
    switches are left out. The first figure comes with its 95 % interval.
    """
    kept = methods if controls else {name: scores.without_controls for name, scores in methods.items()}
    titles = [Column(FIGURE[key].title, DECIMALS[FIGURE[key].unit]) for key in figures]
    columns = (Column("method"), Column("objects", 0), Column("joints", 0), titles[0], INTERVAL, *titles[1:])
    rows: list[tuple[Cell, ...]] = []
    for name, scores in kept.items():
        summary = scores.summary
        estimates = summary.micro if macro_over is None else summary.macro[macro_over]
        values = [_value(estimates, key) for key in figures]
        first = estimates[figures[0]]
        interval = None if first is None else first.interval(DECIMALS[FIGURE[figures[0]].unit])
        rows.append((name, summary.objects, summary.joints, values[0], interval, *values[1:]))
    over = "over joints" if macro_over is None else f"over categories with >= {macro_over} objects"
    caption = caption.noting(f"Means {over}." if controls else f"Means {over}. Without buttons, knobs and switches.")
    return Table(caption_for(_most(kept), caption), columns, tuple(rows))


def category_tables(methods: Rows, caption: Caption, *, whole: bool = True) -> dict[str, Table]:
    """Angle and distance of one setting by category, by name of the table; `whole` is as in `by_category`.

    `methods` holds the paper's four rows and whatever rows belong beside them, in the order of printing.
    """
    by_figure = {
        "angle": ("axis", "axis error in degrees"),
        "angle_type_given": ("typed_axis", "axis error in degrees, the true type given"),
        "distance": ("raw_line", "distance of the axis lines in the files' lengths"),
        "distance_over_diagonal": ("line", "distance of the axis lines over the diagonal"),
    }
    return {
        name: by_category(methods, figure, _titled(caption, title), whole=whole) for name, (figure, title) in by_figure.items()
    }


def overviews(methods: Rows, caption: Caption) -> dict[str, Table]:
    """All rows of one setting (frame rows and ablations too) in overviews, by name of the table."""
    tables = {}
    for suffix, controls in (("", True), ("_without_controls", False)):
        for kind, least in (("micro", None), *((f"macro{least}", least) for least in LEAST_OBJECTS)):
            figures = (*OVERVIEW, *DISTANCES, *GROUPING)
            title = _titled(caption, "all rows")
            tables[f"overview_{kind}{suffix}"] = overview(methods, title, figures=figures, controls=controls, macro_over=least)
    return tables


def _most(methods: Rows) -> Sequence[ShapeScore]:
    """The scores of the method that has most."""
    return max((scores.shapes for scores in methods.values()), key=len, default=())


def _titled(caption: Caption, what: str) -> Caption:
    return replace(caption, title=f"{caption.title}: {what}")


def _plain(estimate: Estimate | None) -> float | None:
    return None if estimate is None else estimate.value


def _value(estimates: Estimates, figure: str) -> float | None:
    return _plain(estimates.get(figure))
