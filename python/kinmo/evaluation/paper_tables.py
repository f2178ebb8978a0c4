"""Figures printed in the paper, to show beside new ones. They are of the authors' data, never of the same test set."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import cache
from importlib.resources import files
from typing import Any

from kinmo.core.categories import canonical_category

METHODS = ("GNN_coarse", "OBB_coarse", "GNN_fine", "OBB_fine")
"""The four methods of Table 1: the GNN alone, and with an axis chosen among box edges; with 5 types, and with 10."""
MARK = "authors' data"  # mark of printed figures in tables


@cache
def paper_tables() -> dict[str, Any]:
    """Tables 1 to 4 as printed (paper_tables.json). A null in a list is a dash of the paper."""
    text = files("kinmo.evaluation").joinpath("paper_tables.json").read_text(encoding="utf-8")
    tables: dict[str, Any] = json.loads(text)
    return tables


def table1_figures(measure: str) -> dict[str, tuple[float | None, ...]]:
    """Printed "angle" (degrees) or "distance" (lengths of the files) of Table 1 by category, in the order of `METHODS`."""
    rows = paper_tables()["table1"]["categories"]
    return {canonical_category(name): tuple(row[measure]) for name, row in rows.items()}


def mean(values: Sequence[float | None]) -> float | None:
    """Mean of printed figures. A dash (None) does not count; None if there are only dashes."""
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else None


def table1_means(measure: str) -> tuple[float | None, ...]:
    """Means of `table1_figures` over categories. The paper's own means of the distance count its dashes as 0; these do not."""
    return tuple(mean(column) for column in zip(*table1_figures(measure).values(), strict=True))
