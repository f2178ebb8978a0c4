"""Tables of scored URDF files."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from kinmo.evaluation.aggregate import Unit
from kinmo.evaluation.tables import Caption, Cell, Column, Table
from kinmo.evaluation.urdf_scoring.urdf_figures import FIGURES
from kinmo.evaluation.urdf_scoring.urdf_folders import UrdfReport
from kinmo.evaluation.urdf_scoring.urdf_scores import FAILED, MISSING, SCORED

COUNTS = ("objects", SCORED, FAILED, MISSING, "parts", "found", "false_positives")
MEDIANS = {"angle_median": ("median angle", 2), "line_median": ("median line", 4)}
"""Titles and decimals of the columns of medians, by key."""
DECIMALS = {Unit.SHARE: 3, Unit.DEGREES: 2, Unit.DIAGONALS: 4, Unit.LENGTH: 4}


def urdf_table(summary: dict[str, Any], report: UrdfReport, caption: Caption) -> Table:
    """All figures by category, over all parts (micro), and as a mean of categories (macro).

    Args:
        summary: The summary of the report (`summarise_urdf_scores`).
        report: The scores.
        caption: The caption, whose counts are filled in.
    """
    columns = [Column("category"), *(Column(name.replace("_", " "), 0) for name in COUNTS)]
    columns += [Column(figure.title, DECIMALS[figure.unit]) for figure in FIGURES]
    columns += [Column(title, decimals) for title, decimals in MEDIANS.values()]
    groups = [*summary["categories"].items(), ("all parts", summary["micro"])]
    rows: list[tuple[Cell, ...]] = [
        (name, *(group[key] for key in COUNTS), *_values(group), *(group[key] for key in MEDIANS)) for name, group in groups
    ]
    rows.append(("mean of categories", *([None] * len(COUNTS)), *_values(summary["macro"]), *([None] * len(MEDIANS))))
    parts = sum(len(scored.parts) for scored in report.objects)
    return Table(replace(caption, shapes=len(report.objects), joints=parts), tuple(columns), tuple(rows))


def _values(group: dict[str, Any]) -> list[Cell]:
    return [None if group[figure.key] is None else group[figure.key]["value"] for figure in FIGURES]


def urdf_failures_table(report: UrdfReport, caption: Caption) -> Table:
    """The objects that were not scored, with reasons. The counts of the caption are filled in."""
    rows = [(scored.id, scored.category, scored.status, scored.reason) for scored in report.objects if scored.status != SCORED]
    rows += [(name, "", "truth not readable", reason) for name, reason in report.unreadable.items()]
    counts = replace(caption, shapes=len(rows), joints=sum(len(s.parts) for s in report.objects if s.status != SCORED))
    return Table(counts, (Column("object"), Column("category"), Column("status"), Column("reason")), tuple(rows))
