"""Rows of the tables of scans: the labels that networks learn from, and the scans that they are tested on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, get_args

from kinmo.core.categories import same_category
from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.paper_tables import paper_tables
from kinmo.experiments.variant_workspaces import Variant
from kinmo.methods import DEFAULT_METHOD
from kinmo.pipeline.scans.scan_dataset import PAPER_CATEGORIES
from kinmo.pipeline.scans.scan_networks import ScanRun
from kinmo.pipeline.scans.scan_scores import ScanScores
from kinmo.pipeline.scans.training_settings import Setting

SHARES = (1.0, 0.8, 0.5, 0.3)  # shares of the labels in Table 3
PAPER = "paper"
Sensor = Literal["ideal", "noisy"]
SENSORS: tuple[Sensor, ...] = get_args(Sensor)


@dataclass(frozen=True)
class TableRow:
    """A row of a table of scans. Rows with other labels have the same test scans."""

    title: str
    setting: Setting  # labels besides those of the labelled shapes
    variant: Variant = field(default_factory=Variant)  # workspace that networks are trained in
    printed: str = ""  # name of the row in the paper; empty if it has none
    method: str = DEFAULT_METHOD  # whose pseudo labels are used
    tested_on: Sensor = "ideal"  # sensor of the test scans

    @property
    def tested_variant(self) -> Variant:
        """Variant whose test scans are used."""
        return Variant(is_noisy=self.tested_on == "noisy")

    def run(self, category: str, seed: int) -> ScanRun:
        """Networks of the row."""
        return ScanRun(category, self.setting, seed, self.method)

    def scores(self, root: Workspace, category: str, seed: int) -> ScanScores:
        """Scores of the row's networks."""
        place, scanned = self.variant.workspace(root), self.tested_variant.workspace(root)
        title = self.tested_on if self.variant.is_noisy != self.tested_variant.is_noisy else ""
        return ScanScores(place, self.run(category, seed), None if scanned == place else scanned, title)


def with_method(title: str, method: str) -> str:
    """Title of a row, with the method whose pseudo labels it learns from unless that is the default."""
    return title if method == DEFAULT_METHOD else f"{title}, {method}"


def _of_both_methods(title: str, printed: str = "", variant: Variant | None = None) -> tuple[TableRow, TableRow]:
    """A semi-weakly supervised row with kinmo's pseudo labels, and one with the paper's, beside the printed figures."""
    own, of_paper = variant or Variant(), with_method(title, PAPER)
    return TableRow(title, "semi-weakly", own), TableRow(of_paper, "semi-weakly", own, printed, PAPER)


@dataclass(frozen=True)
class ScanTable:
    """A table of scans for the categories with printed figures, or else for those that it is made of.

    `compared` are pairs of row titles; the difference of the second to the first is shown too.
    """

    title: str
    categories: tuple[str, ...]
    rows: tuple[TableRow, ...]
    compared: tuple[tuple[str, str], ...]
    note: str = ""


_ROWS_OF_SHARES = tuple(
    row
    for share in SHARES
    for row in _of_both_methods(f"semi-weakly, {share:.0%}", f"Semi-weakly ({share:.0%})", Variant(labels=share))
)
METHODS_NOTE = "Rows with the word paper learn from pseudo labels of --method paper, the others from kinmo's."
SENSOR_LABELS: Mapping[Setting, str] = {"supervised": "scans", "semi-weakly": "scans and pseudo labels"}
"""Settings in the study of sensors, with the training data in words."""


def _sensor_title(trained: Sensor, tested: Sensor, setting: Setting) -> str:
    return f"{trained} {SENSOR_LABELS[setting]}, tested on {tested}"


TABLES: Mapping[str, ScanTable] = {
    "2": ScanTable(
        "Table 2, poses and joints from partial scans",
        PAPER_CATEGORIES,
        (
            TableRow("supervised", "supervised", printed="ANCSH"),
            TableRow("self-training", "self-training", printed="ANCSH (Semi)"),
            *_of_both_methods("semi-weakly", "ANCSH (Semi-weakly)"),
            TableRow("oracle labels", "oracle"),
        ),
        (
            ("supervised", "self-training"),
            ("supervised", "semi-weakly"),
            ("supervised", with_method("semi-weakly", PAPER)),
            (with_method("semi-weakly", PAPER), "semi-weakly"),
        ),
        f"{METHODS_NOTE} Oracle labels: the true labels of the shapes that the other rows pseudo-label, an upper bound. "
        "Self-training uses scans of all unlabelled objects, whatever their structure.",
    ),
    "3": ScanTable(
        "Table 3, fewer labels",
        ("Refrigerator", "Scissors"),
        (*_ROWS_OF_SHARES, TableRow("supervised, 100%", "supervised", printed="Supervised (100%)")),
        tuple(("supervised, 100%", row.title) for row in _ROWS_OF_SHARES),
        f"{METHODS_NOTE} Fewer labels mean fewer for the motion networks, for axis selection and for ANCSH alike.",
    ),
    "4": ScanTable(
        "Table 4, generated shapes as the unlabelled ones",
        ("StorageFurniture",),
        (
            TableRow("supervised", "supervised", printed="ANCSH"),
            *_of_both_methods("generated shapes", "ANCSH (DSG)", Variant(generated=True)),
        ),
        (("supervised", "generated shapes"), ("supervised", with_method("generated shapes", PAPER))),
        f"{METHODS_NOTE} Generated shapes are all shapes in DSG-Net's layout in the workspace; the authors' came from DSG-Net.",
    ),
    "sensors": ScanTable(
        "Sensors",
        ("Refrigerator",),
        tuple(
            TableRow(_sensor_title(trained, tested, setting), setting, Variant(is_noisy=trained == "noisy"), tested_on=tested)
            for setting in SENSOR_LABELS
            for trained in SENSORS
            for tested in SENSORS
        ),
        (
            *(
                (_sensor_title("ideal", tested, setting), _sensor_title("noisy", tested, setting))
                for setting in SENSOR_LABELS
                for tested in SENSORS
            ),
            *(
                (_sensor_title("noisy", tested, "supervised"), _sensor_title("noisy", tested, "semi-weakly"))
                for tested in SENSORS
            ),
        ),
        "Noisy scans are the ideal scans with noise, holes and crops, and without surfaces at grazing angles. Pseudo labels "
        "are kinmo's.",
    ),
}
"""All tables of scans, by their names for `kinmo table`."""


def is_about(name: str, category: str) -> bool:
    """True if a table is about a category; for the paper's tables, if it prints figures for it."""
    return any(same_category(category, known) for known in TABLES[name].categories)


def is_printed(name: str, category: str) -> bool:
    """True if the paper prints figures of a table for a category."""
    return any(printed_row(name, category, row.printed) for row in TABLES[name].rows)


def printed_row(table: str, category: str, name: str) -> list[list[float | None]] | None:
    """Figures that the paper prints in a row of a table; None if it has no such row."""
    for known, rows in paper_tables().get(f"table{table}", {"categories": {}})["categories"].items():
        if same_category(known, category):
            found: list[list[float | None]] | None = rows.get(name)
            return found
    return None
