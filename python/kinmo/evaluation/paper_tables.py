"""The figures that the paper prints, to be shown beside one's own: the authors' data, never the same test set."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import cache
from importlib.resources import files
from typing import Any

from kinmo.core.categories import canonical_category

METHODS = ("GNN_coarse", "OBB_coarse", "GNN_fine", "OBB_fine")
"""The four rows of Table 1: the network alone, and with its axes chosen among those of boxes; with 5 types, and with 10."""
MARK = "authors' data"


@cache
def paper_tables() -> dict[str, Any]:
    """Tables 1 to 4 as printed (paper_tables.json). In lists a null is a dash of the paper."""
    text = files("kinmo.evaluation").joinpath("paper_tables.json").read_text(encoding="utf-8")
    tables: dict[str, Any] = json.loads(text)
    return tables


def table1_figures(measure: str) -> dict[str, tuple[float | None, ...]]:
    """Table 1's figures by category, in the order of METHODS: angles (degrees) or distances (the files' lengths)."""
    rows = paper_tables()["table1"]["categories"]
    return {canonical_category(name): tuple(row[measure]) for name, row in rows.items()}


def mean(values: Sequence[float | None]) -> float | None:
    """The mean of what is printed; a dash does not count."""
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else None


def table1_means(measure: str) -> tuple[float | None, ...]:
    """Means over the categories of Table 1, in the order of METHODS.

    The means that the paper prints for the distance count its dashes as 0.
    """
    return tuple(mean(column) for column in zip(*table1_figures(measure).values(), strict=True))
