"""Tables of shape scores: the paper's Table 1 and overviews of all methods."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from kinmo.core.categories import canonical_category
from kinmo.evaluation.aggregate import Unit
from kinmo.evaluation.joint_records import ShapeScore
from kinmo.evaluation.paper_tables import MARK, METHODS, table1_figures, table1_means
from kinmo.evaluation.score_summary import FIGURE_BY_KEY, MEDIANS, MIN_OBJECTS, Summary, summarise_scores, without_controls
from kinmo.evaluation.tables import INTERVAL, Caption, Column, Table, Values


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


Rows = Mapping[str, Scores]  # the scores of every method, by its name in the tables

DECIMALS = {Unit.SHARE: 3, Unit.DEGREES: 2, Unit.DIAGONALS: 3, Unit.LENGTH: 3}
"""Printed decimals of a figure by its unit."""
COUNTS = (Column("objects", 0), Column("joints", 0))
PAPER_MEASURE = {"axis": "angle", "raw_line": "distance"}
"""The measures that the paper prints, by key of the figure. Its distances are in the lengths of the files."""

# keys of the figures in overviews
OVERVIEW = ("ok", "coarse_type", "fine_type", "missed", "axis", "typed_axis", "axis_ok", "axis_and_line_ok", "hinge_within_10")
DISTANCES = ("line", "line_at_part", "pivot", "range_iou", "penetration")
SUMMARY = ("ok", "coarse_type", "axis", "axis_ok", "missed", "f1")
MAX_SUMMARY_ROWS = 12
GROUPING = ("precision", "recall", "f1", "parent", "edge_type")


def caption_for(scores: Sequence[ShapeScore], caption: Caption) -> Caption:
    """The caption with the numbers of shapes and joints of the scores."""
    joints = {(record.shape_id, record.body) for score in scores for record in score.records}
    return replace(caption, shapes=len({score.shape_id for score in scores}), joints=len(joints))


def by_category(methods: Rows, figure: str, caption: Caption, *, whole: bool = True) -> Table:
    """Table of one figure: a row for each category, a column for each method, with means below and the paper's figures beside.

    The counts of the caption are filled in. A table of the `whole` has a row for each category of the paper, run or not, and
    means over categories; others have the categories that were run alone.
    """
    summaries = {name: scores.summary for name, scores in methods.items()}
    paper = table1_figures(PAPER_MEASURE[figure]) if figure in PAPER_MEASURE else {}
    printed = [f"{name} ({MARK})" for name in METHODS] if paper else []
    decimals = DECIMALS[FIGURE_BY_KEY[figure].unit]
    columns = [Column("category"), *COUNTS, *(Column(name, decimals) for name in (*summaries, *printed))]
    spellings = {canonical_category(name): name for summary in summaries.values() for name in summary.categories}
    rows: list[Values] = []
    for category in sorted({*spellings, *paper} if whole else spellings):
        found = {name: summary.categories.get(spellings.get(category, "")) for name, summary in summaries.items()}
        first = next(filter(None, found.values()), None)
        counts = {"objects": first.objects if first else 0, "joints": first.joints if first else 0}
        figures = {name: group.micro[figure] for name, group in found.items() if group is not None}
        rows.append({"category": category, **counts, **figures, **dict(zip(printed, paper.get(category, ()), strict=False))})
    for least in MIN_OBJECTS if whole else ():
        means = {name: summary.macro[least][figure] for name, summary in summaries.items()}
        count = max((mean.count for mean in means.values() if mean is not None), default=0)
        rows.append({"category": f"mean of {count} categories with >= {least} objects", **means})
    rows.append({"category": "mean of joints", **{name: summary.micro[figure] for name, summary in summaries.items()}})
    if paper and whole:
        means_of_paper = zip(printed, table1_means(PAPER_MEASURE[figure]), strict=True)
        rows.append({"category": "mean of the paper's categories", **dict(means_of_paper)})
    if figure in MEDIANS:
        rows.append({"category": "median of joints", **{name: summary.medians[figure] for name, summary in summaries.items()}})
    return Table.of(caption_for(_most(methods), caption), columns, rows)


def overview(
    methods: Rows, caption: Caption, *, figures: Sequence[str] = OVERVIEW, controls: bool = True, macro_over: int | None = None
) -> Table:
    """Table of several figures: a row for each method, a column for each figure, the first with its 95 % interval.

    The counts of the caption are filled in. Means are over joints, or over categories with at least `macro_over` objects.
    """
    kept = methods if controls else {name: scores.without_controls for name, scores in methods.items()}
    titles = {key: FIGURE_BY_KEY[key].title for key in figures}
    first, *others = [Column(titles[key], DECIMALS[FIGURE_BY_KEY[key].unit]) for key in figures]
    rows: list[Values] = []
    for name, scores in kept.items():
        summary = scores.summary
        estimates = summary.micro if macro_over is None else summary.macro[macro_over]
        values = {title: estimates[key] for key, title in titles.items()}
        rows.append({"method": name, "objects": summary.objects, "joints": summary.joints, **values})
    over = "over joints" if macro_over is None else f"over categories with >= {macro_over} objects"
    caption = caption.noting(f"Means {over}." if controls else f"Means {over}. Without buttons, knobs and switches.")
    return Table.of(caption_for(_most(kept), caption), (Column("method"), *COUNTS, first, INTERVAL, *others), rows)


def summary_table(methods: Rows, caption: Caption) -> Table:
    """The most important figures of at most `MAX_SUMMARY_ROWS` rows; those with a comma, such as ablations, come last."""
    names = sorted(methods, key=lambda name: "," in name)[:MAX_SUMMARY_ROWS]
    kept = {name: scores for name, scores in methods.items() if name in names}
    return overview(kept, caption, figures=SUMMARY)


def category_tables(methods: Rows, caption: Caption, *, whole: bool = True) -> dict[str, Table]:
    """Tables of the axis error and the line distance by category (`by_category`), by name of the table."""
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
    caption, figures = _titled(caption, "all rows"), (*OVERVIEW, *DISTANCES, *GROUPING)
    return {
        f"overview_{kind}{suffix}": overview(methods, caption, figures=figures, controls=controls, macro_over=least)
        for suffix, controls in (("", True), ("_without_controls", False))
        for kind, least in (("micro", None), *((f"macro{least}", least) for least in MIN_OBJECTS))
    }


def _most(methods: Rows) -> Sequence[ShapeScore]:
    """The scores of the method with most shapes."""
    return max((scores.shapes for scores in methods.values()), key=len, default=())


def _titled(caption: Caption, what: str) -> Caption:
    return replace(caption, title=f"{caption.title}: {what}")
