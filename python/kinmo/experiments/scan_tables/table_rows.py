"""What the rows of Tables 2, 3 and 4 of the paper are of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from kinmo.core.categories import same_category
from kinmo.dataset.workspace import DEFAULT_METHOD, Workspace
from kinmo.evaluation.paper_tables import paper_tables
from kinmo.pipeline.scans.scan_dataset import PAPER_CATEGORIES
from kinmo.pipeline.scans.scan_networks import Cell
from kinmo.pipeline.scans.scored_scans import JudgedScans
from kinmo.pipeline.scans.training_settings import Setting, by_method

SHARES = (1.0, 0.8, 0.5, 0.3)
"""Of the labelled shapes, in Table 3."""


@dataclass(frozen=True)
class RowOf:
    """A row of a table: networks of a `setting`, with a share of the labels, and what the paper calls it, if it has it.

    `method` is whose pseudo labels networks learn from, if they do. Networks are trained on scans by the rough sensor if
    they are `of_rough`, and judged on those if `on_rough`.
    """

    title: str
    setting: Setting
    labels: float = 1.0
    printed: str = ""
    of_rough: bool = False
    on_rough: bool = False
    method: str = DEFAULT_METHOD

    def workspace(self, root: Workspace) -> Workspace:
        """The one, in `root`, with the row's share of labels, and the pseudo labels of its method."""
        return Workspace(root.root, self.labels, self.of_rough, self.method)

    def cell(self, category: str, seed: int) -> Cell:
        """The networks of the row."""
        return Cell(category, self.setting, seed)

    def judged(self, root: Workspace, category: str, seed: int) -> JudgedScans:
        """What the networks of the row are judged on, in `root`."""
        return JudgedScans(self.workspace(root), self.cell(category, seed), self.on_rough)


PAPER = "paper"
"""The method, beside the default one, that rows learn from pseudo labels of."""
METHODS = "Rows with the word paper learn from pseudo labels by --method paper, those beside them by kinmo."


def _by_both_methods(title: str, setting: Setting, labels: float = 1.0, printed: str = "") -> tuple[RowOf, RowOf]:
    """A row by kinmo's pseudo labels, and one by the paper's, which has the paper's figures."""
    return RowOf(title, setting, labels), RowOf(by_method(title, PAPER), setting, labels, printed, method=PAPER)


SENSORS = CLEAN, ROUGH = "clean", "rough"
SEEN_BY_SENSORS: Mapping[Setting, str] = {"supervised": "scans", "semi-weakly": "scans and pseudo labels"}
"""Settings of which networks are trained by either sensor, and what they are trained on, in words."""


def _by_sensors(trained: str, tested: str, setting: Setting) -> str:
    return f"{trained} {SEEN_BY_SENSORS[setting]}, tested on {tested}"


@dataclass(frozen=True)
class ScanTable:
    """A table; `categories` are those that the paper has figures of, or else that it is made of.

    Of each pair of titles that are `compared`, what the second row has gained over the first is shown too.
    """

    title: str
    categories: tuple[str, ...]
    rows: tuple[RowOf, ...]
    compared: tuple[tuple[str, str], ...]
    note: str = ""


TABLES: Mapping[str, ScanTable] = {
    "2": ScanTable(
        "Table 2, poses and joints from partial scans",
        PAPER_CATEGORIES,
        (
            RowOf("supervised", "supervised", printed="ANCSH"),
            RowOf("semi", "semi", printed="ANCSH (Semi)"),
            *_by_both_methods("semi-weakly", "semi-weakly", printed="ANCSH (Semi-weakly)"),
            RowOf("true labels", "ceiling"),
        ),
        (
            ("supervised", "semi"),
            ("supervised", "semi-weakly"),
            ("supervised", by_method("semi-weakly", PAPER)),
            (by_method("semi-weakly", PAPER), "semi-weakly"),
        ),
        f"{METHODS} True labels: those of the shapes that the others have no labels of, the best that pseudo labels could do. "
        "Semi sees the scans of all unlabelled objects, whatever their structure.",
    ),
    "3": ScanTable(
        "Table 3, fewer labels",
        ("Refrigerator", "Scissors"),
        (
            *(
                row
                for share in SHARES
                for row in _by_both_methods(
                    f"semi-weakly, {share:.0%}", "semi-weakly", share, printed=f"Semi-weakly ({share:.0%})"
                )
            ),
            RowOf("supervised, 100%", "supervised", printed="Supervised (100%)"),
        ),
        tuple(
            ("supervised, 100%", title)
            for share in SHARES
            for title in (f"semi-weakly, {share:.0%}", by_method(f"semi-weakly, {share:.0%}", PAPER))
        ),
        f"{METHODS} Fewer labels are fewer for the motion networks, for what chooses axes and for ANCSH alike.",
    ),
    "4": ScanTable(
        "Table 4, shapes in the layout of DSG-Net as the unlabelled ones",
        ("StorageFurniture",),
        (
            RowOf("supervised", "supervised", printed="ANCSH"),
            *_by_both_methods("generated shapes", "dsg-net", printed="ANCSH (DSG)"),
        ),
        (("supervised", "generated shapes"), ("supervised", by_method("generated shapes", PAPER))),
        f"{METHODS} These generated shapes are not DSG-Net's own, as the authors' are, but whatever the workspace has in its "
        "layout.",
    ),
    "sensors": ScanTable(
        "Sensors",
        ("Refrigerator",),
        tuple(
            RowOf(_by_sensors(trained, tested, setting), setting, of_rough=trained == ROUGH, on_rough=tested == ROUGH)
            for setting in SEEN_BY_SENSORS
            for trained in SENSORS
            for tested in SENSORS
        ),
        (
            *(
                (_by_sensors(CLEAN, tested, setting), _by_sensors(ROUGH, tested, setting))
                for setting in SEEN_BY_SENSORS
                for tested in SENSORS
            ),
            *((_by_sensors(ROUGH, tested, "supervised"), _by_sensors(ROUGH, tested, "semi-weakly")) for tested in SENSORS),
        ),
        "Rough scans are the same scans with noise, holes and crops, and without what is seen too flatly. Pseudo labels are by "
        "--method kinmo.",
    ),
}
"""By what `kinmo table` calls them."""


def has_figures(name: str, category: str) -> bool:
    """Whether a table is of a category, which for the paper's is whether it prints figures."""
    return any(same_category(category, name) for name in TABLES[name].categories)


def is_printed(name: str, category: str) -> bool:
    """Whether a table is one of the paper's, and has figures of a category there."""
    return any(printed_row(name, category, row.printed) for row in TABLES[name].rows)


def printed_row(table: str, category: str, name: str) -> list[list[float | None]] | None:
    """What the paper prints in a row of a table; None where it has no such row."""
    for known, rows in paper_tables().get(f"table{table}", {"categories": {}})["categories"].items():
        if same_category(known, category):
            found: list[list[float | None]] | None = rows.get(name)
            return found
    return None
