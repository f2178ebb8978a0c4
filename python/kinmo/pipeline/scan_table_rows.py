"""What the rows of Tables 2, 3 and 4 of the paper are of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from kinmo.categories import same_category
from kinmo.evaluation.paper_tables import paper_tables
from kinmo.pipeline.ancsh_files import Cell
from kinmo.pipeline.scan_dataset import PAPER_CATEGORIES, Setting
from kinmo.workspace import Workspace

SHARES = (1.0, 0.8, 0.5, 0.3)
"""Of the labelled shapes, in Table 3."""


@dataclass(frozen=True)
class RowOf:
    """A row of a table: networks of a `setting`, with a share of the labels, and what the paper calls it, if it has it."""

    title: str
    setting: Setting
    labels: float = 1.0
    printed: str = ""

    def workspace(self, root: Workspace) -> Workspace:
        """The one, in `root`, with the row's share of labels."""
        return Workspace(root.root, self.labels)

    def cell(self, category: str, seed: int) -> Cell:
        """The networks of the row."""
        return Cell(category, self.setting, seed)


@dataclass(frozen=True)
class ScanTable:
    """One of the paper's tables; `categories` are those that it has figures of."""

    number: int
    title: str
    categories: tuple[str, ...]
    rows: tuple[RowOf, ...]
    note: str = ""


TABLES: Mapping[int, ScanTable] = {
    2: ScanTable(
        2,
        "Poses and joints from partial scans",
        PAPER_CATEGORIES,
        (
            RowOf("supervised", "supervised", printed="ANCSH"),
            RowOf("semi", "semi", printed="ANCSH (Semi)"),
            RowOf("semi-weakly", "semi-weakly", printed="ANCSH (Semi-weakly)"),
            RowOf("true labels", "ceiling"),
        ),
        "True labels: those of the shapes that the others have no labels of, the best that pseudo labels could do.",
    ),
    3: ScanTable(
        3,
        "Fewer labels",
        ("Refrigerator", "Scissors"),
        (
            *(
                RowOf(f"semi-weakly, {share:.0%}", "semi-weakly", share, printed=f"Semi-weakly ({share:.0%})")
                for share in SHARES
            ),
            RowOf("supervised, 100%", "supervised", printed="Supervised (100%)"),
        ),
        "Fewer labels are fewer for the motion networks, for what chooses axes and for ANCSH alike.",
    ),
    4: ScanTable(
        4,
        "Shapes in the layout of DSG-Net as the unlabelled ones",
        ("StorageFurniture",),
        (
            RowOf("supervised", "supervised", printed="ANCSH"),
            RowOf("generated shapes", "dsg-net", printed="ANCSH (DSG)"),
        ),
        "The authors' generated shapes are DSG-Net's own; these are whatever the workspace has in its layout.",
    ),
}


def has_figures(number: int, category: str) -> bool:
    """Whether the paper has figures of a category in a table."""
    return any(same_category(category, name) for name in TABLES[number].categories)


def printed_row(number: int, category: str, name: str) -> list[list[float | None]] | None:
    """What the paper prints in a row of a table; None where it has no such row."""
    for known, rows in paper_tables()[f"table{number}"]["categories"].items():
        if same_category(known, category):
            found: list[list[float | None]] | None = rows.get(name)
            return found
    return None
