"""Tables of scans on disk, made from the scores that there are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kinmo.core.categories import same_category
from kinmo.core.errors import InputError
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.stage import Outcome
from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.scan_records import ACCURACIES, Measure
from kinmo.evaluation.tables import Caption, Table, as_text, write_table
from kinmo.experiments.scan_tables.category_rows import CategoryRows, InputsBySeed, current_scores
from kinmo.experiments.scan_tables.scan_table_layout import (
    ScanRow,
    by_part,
    means_alone,
    over_categories,
    over_parts,
    printed_structure,
    without_structure,
)
from kinmo.experiments.scan_tables.table_notes import gaps, objects_in_words, pseudo_labels, seed_by_seed
from kinmo.experiments.scan_tables.table_rows import TABLES
from kinmo.pipeline.evaluation.evaluation_folder import ALL
from kinmo.pipeline.scans.scan_dataset import ScanDataset, open_scan_dataset
from kinmo.pipeline.scans.scan_scores import PROTOCOLS, Protocol

PROTOCOL_TITLES: Mapping[Protocol, str] = {"kinmo": "", "ancsh": ", as ANCSH's public code measures"}
MORE_MEASURES: Mapping[Protocol, Sequence[Measure]] = {"kinmo": (), "ancsh": ACCURACIES}
"""Additional measures, part by part."""
PRINTED_NOTE = "Printed figures come from the authors' data, and are measured as --protocol ancsh measures."
AGAINST_NOTE = (
    "Rows with the word against show the difference of the first to the second, over the seeds that both have, and over the "
    "parts and joints of each frame that both found."
)
Inputs = Mapping[str, InputsBySeed]  # inputs of the up-to-date scores, by category


@dataclass(frozen=True)
class WrittenTables:
    """The table of scans `name` of `TABLES`, for one category or several. Missing and outdated rows say so.

    The workspace is the original one. With `details`, all figures of every part are printed.
    """

    workspace: Workspace
    name: str
    details: bool = False

    @property
    def folder(self) -> Path:
        """Folder with a subfolder for each category, and one for all."""
        return self.workspace.evaluation / f"table-{self.name}"

    def write(self, seeds: Mapping[str, Sequence[int]], shown: Protocol = "kinmo") -> Outcome:
        """Write the table by every protocol, with some seeds by category; `shown` is the protocol of the printed table."""
        with self.workspace.locked():
            return self._write(self._inputs_by_category(seeds), shown)

    def _write(self, whole: Inputs, shown: Protocol) -> Outcome:
        texts, data = [], {}
        places = {category: {category: by_seed} for category, by_seed in whole.items()}
        for place, inputs in (places | {ALL: whole} if len(whole) > 1 else places).items():
            paths: list[Path] = []
            for protocol in PROTOCOLS:
                tables = self._of_all(inputs, protocol) if place == ALL else self._of(place, inputs[place], protocol)
                for name, table in tables.items():
                    paths += write_table(table, self.folder / place, name if protocol == "kinmo" else f"{name}_{protocol}")
                if protocol == shown:
                    printed = [name for name in tables if (name == "summary") is not self.details or len(tables) == 1]
                    texts += [as_text(tables[name]) for name in printed]
                    data[place] = {
                        name: {"columns": [column.title for column in table.columns], "rows": table.rows}
                        for name, table in tables.items()
                    }
            for old in {*(self.folder / place).iterdir()}.difference(paths):
                old.unlink()
            self.workspace.record(self._stage(place), _plain(inputs), paths)
        return Outcome(self.folder, data, "\n".join(texts))

    def is_current(self, place: str) -> bool:
        """True if the tables of a category, or of `ALL`, show the present scores."""
        inputs = self.workspace.inputs_of(self._stage(place))
        if inputs is None:
            return False
        seeds = {category: list(map(int, by_seed)) for category, by_seed in inputs["scores"].items()}
        return self.workspace.is_current(self._stage(place), _plain(self._inputs_by_category(seeds)))

    def _inputs_by_category(self, seeds: Mapping[str, Sequence[int]]) -> Inputs:
        return {category: current_scores(self.workspace, self.name, category, own) for category, own in seeds.items()}

    def _of(self, category: str, inputs: InputsBySeed, protocol: Protocol) -> dict[str, Table]:
        """Tables of one category: a summary, means over all parts with intervals, and part by part."""
        rows = CategoryRows(self.workspace, self.name, category, inputs, protocol)
        shown, more = [rows.row(row) for row in TABLES[self.name].rows], MORE_MEASURES[protocol]
        dataset = self._dataset(category)
        reasons = [f"Not run: {row.name}: {row.reason}." for row in shown if row.reason]
        if isinstance(dataset, InputError):
            caption = self._caption(category, "no scans to test on", shown, protocol).noting(f"{dataset.problem}.", *reasons)
            printed = next((row.printed for row in shown if row.printed is not None), None)
            if printed is None:
                return {"means": without_structure(shown, caption)}
            structure = printed_structure(printed)
            return {"means": over_parts(shown, structure, caption), "parts": by_part(shown, structure, caption, more)}
        structure = dataset.structure
        objects = objects_in_words(self.workspace, dataset)
        caption = self._caption(str(structure), objects, shown, protocol)
        compared = [pair for titles in TABLES[self.name].compared if (pair := rows.comparable(titles))]
        notes = (*gaps(rows, structure), *seed_by_seed(rows, structure), *pseudo_labels(rows, shown), *reasons)
        short = Caption(f"{TABLES[self.name].title}: {category}", f"{structure}", 0, 0, "test split", caption.seeds)
        return {
            "summary": means_alone(shown, structure, short),
            "means": over_parts(shown, structure, caption.noting(*notes, AGAINST_NOTE if compared else ""), compared),
            "parts": by_part(shown, structure, caption, more),
        }

    def _of_all(self, inputs: Inputs, protocol: Protocol) -> dict[str, Table]:
        """Means over categories. (The paper's own means mix degrees and lengths.)"""
        datasets = {name: self._dataset(name) for name in inputs}
        structures = {name: found.structure for name, found in datasets.items() if isinstance(found, ScanDataset)}
        by_category = {name: CategoryRows(self.workspace, self.name, name, own, protocol) for name, own in inputs.items()}
        rows = {row.title: {name: own.row(row) for name, own in by_category.items()} for row in TABLES[self.name].rows}
        every = [row for own in rows.values() for row in own.values()]
        caption = self._caption("means over categories", ", ".join(inputs), every, protocol)
        labelled = open_dataset(self.workspace).categories()
        absent = [name for name in TABLES[self.name].categories if not any(same_category(name, there) for there in labelled)]
        if absent:
            caption = caption.noting(f"Not run: {', '.join(absent)}: there are no labelled shapes.")
        return {"means": over_categories(rows, structures, caption)}

    def _caption(self, what: str, of: str, rows: Sequence[ScanRow], protocol: Protocol) -> Caption:
        table = TABLES[self.name]
        title = f"{table.title}{PROTOCOL_TITLES[protocol]}: {what}"
        data = f"{of} of workspace {self.workspace.path.absolute().name}"
        seeds = tuple(sorted({seed for row in rows for seed in row.seeds}))
        caption = Caption(title, data, 0, 0, "test split by hashed id", seeds)
        has_printed = any(row.printed is not None for row in rows)
        return caption.noting(table.note, PRINTED_NOTE if protocol == "kinmo" and has_printed else "")

    def _dataset(self, category: str) -> ScanDataset | InputError:
        """The scans of a category, or the problem with them."""
        try:
            return open_scan_dataset(self.workspace, category)
        except InputError as error:
            return error

    def _stage(self, place: str) -> str:
        return f"table-{self.name}-{place}"


def _plain(inputs: Inputs) -> dict[str, Any]:
    """Inputs as JSON has them, with text as keys."""
    return {"scores": {name: {str(seed): dict(rows) for seed, rows in by_seed.items()} for name, by_seed in inputs.items()}}
