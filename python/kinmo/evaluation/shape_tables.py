"""Tables of shape scores: the paper's Table 1 and overviews of all methods."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from kinmo.core.categories import canonical_category
from kinmo.evaluation.aggregate import Estimate, Unit
from kinmo.evaluation.joint_records import ShapeScore
from kinmo.evaluation.paper_tables import MARK, METHODS, table1_figures, table1_means
from kinmo.evaluation.score_summary import FIGURE_BY_KEY, MIN_OBJECTS, Estimates, Summary, summarise_scores, without_controls
from kinmo.evaluation.tables import INTERVAL, Caption, Cell, Column, Table


@dataclass(frozen=True, eq=False)
class Scores:
    """The scores of one method. They are summarised once for all tables."""

    shapes: Sequence[ShapeScore]

    @cached_property
    def summary(self) -> Summary:
        """The figures of the scores."""
        return summarise_scores(self.shapes)

    @cached_property
    def without_controls(self) -> Scores:
        """The scores without buttons, knobs and switches."""
        return Scores(without_controls(self.shapes))


Rows = Mapping[str, Scores]
"""The scores of every method, by its name in the tables."""

DECIMALS = {Unit.SHARE: 3, Unit.DEGREES: 2, Unit.DIAGONALS: 3, Unit.LENGTH: 3}
"""Printed decimals of a figure by its unit."""
PAPER_MEASURE = {"axis": "angle", "raw_line": "distance"}
"""The measures that the paper prints, by key of the figure. Its distances are in the lengths of the files."""

OVERVIEW = ("ok", "coarse_type", "fine_type", "missed", "axis", "typed_axis", "axis_ok", "axis_and_line_ok", "hinge_within_10")
DISTANCES = ("line", "line_at_part", "pivot", "range_iou", "penetration")
SUMMARY = ("ok", "coarse_type", "axis", "axis_ok", "missed", "f1")
MAX_SUMMARY_ROWS = 12
GROUPING = ("precision", "recall", "f1", "parent", "edge_type")
"""Keys of the figures in overviews."""


def caption_for(scores: Sequence[ShapeScore], caption: Caption) -> Caption:
    """The caption with the numbers of shapes and joints of the scores."""
    joints = {(record.shape_id, record.body) for score in scores for record in score.records}
    return replace(caption, shapes=len({score.shape_id for score in scores}), joints=len(joints))


def by_category(methods: Rows, figure: str, caption: Caption, *, whole: bool = True) -> Table:
    """Table of one figure: a row for each category, a column for each method, with means below and the paper's figures beside.

    Args:
        methods: The scores of each method.
        figure: Key of the figure.
        caption: The caption, whose counts are filled in.
        whole: True for a table of all categories. It has a row for each category of the paper, run or not, and means over
            categories. False for the categories that were run alone.
    """
    summaries = {name: scores.summary for name, scores in methods.items()}
    paper = table1_figures(PAPER_MEASURE[figure]) if figure in PAPER_MEASURE else {}
    decimals = DECIMALS[FIGURE_BY_KEY[figure].unit]
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
    for least in MIN_OBJECTS if whole else ():
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
    """Table of several figures: a row for each method, a column for each figure, the first with its 95 % interval.

    Args:
        methods: The scores of each method.
        caption: The caption, whose counts are filled in.
        figures: Keys of the figures.
        controls: False to leave out buttons, knobs and switches.
        macro_over: None for means over joints; else means over categories with at least this many objects.
    """
    kept = methods if controls else {name: scores.without_controls for name, scores in methods.items()}
    titles = [Column(FIGURE_BY_KEY[key].title, DECIMALS[FIGURE_BY_KEY[key].unit]) for key in figures]
    columns = (Column("method"), Column("objects", 0), Column("joints", 0), titles[0], INTERVAL, *titles[1:])
    rows: list[tuple[Cell, ...]] = []
    for name, scores in kept.items():
        summary = scores.summary
        estimates = summary.micro if macro_over is None else summary.macro[macro_over]
        values = [_value(estimates, key) for key in figures]
        first = estimates[figures[0]]
        interval = None if first is None else first.interval(DECIMALS[FIGURE_BY_KEY[figures[0]].unit])
        rows.append((name, summary.objects, summary.joints, values[0], interval, *values[1:]))
    over = "over joints" if macro_over is None else f"over categories with >= {macro_over} objects"
    caption = caption.noting(f"Means {over}." if controls else f"Means {over}. Without buttons, knobs and switches.")
    return Table(caption_for(_most(kept), caption), columns, tuple(rows))


def summary_table(methods: Rows, caption: Caption) -> Table:
    """The most important figures of at most `MAX_SUMMARY_ROWS` rows: over all true joints, misses as failures.

    Rows with a comma in their names, such as ablations, come last.
    """
    names = sorted(methods, key=lambda name: "," in name)[:MAX_SUMMARY_ROWS]
    kept = {name: scores for name, scores in methods.items() if name in names}
    return overview(kept, caption, figures=SUMMARY)


def category_tables(methods: Rows, caption: Caption, *, whole: bool = True) -> dict[str, Table]:
    """Tables of the axis error and the line distance by category, by name of the table.

    Args:
        methods: The scores of each method, in the order of the columns.
        caption: The caption, whose title is extended and whose counts are filled in.
        whole: As in `by_category`.
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
    """Overviews of all methods over joints and over categories, with and without controls, by name of the table."""
    tables = {}
    for suffix, controls in (("", True), ("_without_controls", False)):
        for kind, least in (("micro", None), *((f"macro{least}", least) for least in MIN_OBJECTS)):
            figures = (*OVERVIEW, *DISTANCES, *GROUPING)
            title = _titled(caption, "all rows")
            tables[f"overview_{kind}{suffix}"] = overview(methods, title, figures=figures, controls=controls, macro_over=least)
    return tables


def _most(methods: Rows) -> Sequence[ShapeScore]:
    """The scores of the method with most shapes."""
    return max((scores.shapes for scores in methods.values()), key=len, default=())


def _titled(caption: Caption, what: str) -> Caption:
    return replace(caption, title=f"{caption.title}: {what}")


def _plain(estimate: Estimate | None) -> float | None:
    return None if estimate is None else estimate.value


def _value(estimates: Estimates, figure: str) -> float | None:
    return _plain(estimates.get(figure))
