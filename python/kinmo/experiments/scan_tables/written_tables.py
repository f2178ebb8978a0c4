"""Tables 2, 3 and 4 of whatever was judged."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kinmo.core.categories import same_category
from kinmo.core.errors import InputError
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.stage import Outcome
from kinmo.dataset.workspace import StageRecord, Workspace
from kinmo.evaluation.scan_records import ACCURACIES, Measure
from kinmo.evaluation.tables import Caption, Table, as_text, write_table
from kinmo.experiments.scan_tables.category_rows import CategoryRows, HeldBySeed, judgements
from kinmo.experiments.scan_tables.scan_table_layout import (
    ScanRow,
    by_part,
    of_nothing,
    over_categories,
    over_parts,
    printed_structure,
)
from kinmo.experiments.scan_tables.table_notes import gaps, objects_in_words, pseudo_labels, seed_by_seed
from kinmo.experiments.scan_tables.table_rows import TABLES
from kinmo.experiments.table1.evaluation_folder import ALL
from kinmo.pipeline.scans.scan_dataset import ScanDataset, open_scan_dataset
from kinmo.pipeline.scans.scan_networks import PROTOCOLS, Protocol

WAYS: Mapping[Protocol, str] = {"kinmo": "", "ancsh": ", as ANCSH's public code measures"}
MORE: Mapping[Protocol, Sequence[Measure]] = {"kinmo": (), "ancsh": ACCURACIES}
"""What is measured besides, part by part."""
AUTHORS_MEASURE = "The authors' figures are of their data, and measured as --protocol ancsh measures."
AGAINST = (
    "Rows with the word against say by how much the first is above the second, over the seeds that both have, and the parts "
    "and joints of each frame that both have found."
)
Held = Mapping[str, HeldBySeed]
"""By category: the judgements that there are to show."""


@dataclass(frozen=True)
class WrittenTables:
    """A table (`table_rows.TABLES`), a category at a time. Rows that were not run, or are outdated, say so."""

    workspace: Workspace
    name: str

    @property
    def folder(self) -> Path:
        """Where it is written, a folder a category, and one of all where there are several."""
        return self.workspace.evaluation / f"table-{self.name}"

    def write(self, seeds: Mapping[str, Sequence[int]], shown: Protocol = "kinmo") -> Outcome:
        """Write it for the categories of `seeds`, by each protocol; the text is that of the one to be `shown`."""
        with self.workspace.locked():
            return self._write(seeds, shown)

    def _write(self, seeds: Mapping[str, Sequence[int]], shown: Protocol) -> Outcome:
        texts, data = [], {}
        whole = self._held(seeds)
        places = {category: {category: by_seed} for category, by_seed in whole.items()}
        for place, held in (places | {ALL: whole} if len(seeds) > 1 else places).items():
            paths: list[Path] = []
            for protocol in PROTOCOLS:
                tables = self._over_categories(held, protocol) if place == ALL else self._of(place, held[place], protocol)
                for name, table in tables.items():
                    paths += write_table(table, self.folder / place, name if protocol == "kinmo" else f"{name}_{protocol}")
                if protocol == shown:
                    texts += [as_text(table) for table in tables.values()]
                    data[place] = {
                        name: {"columns": [column.title for column in table.columns], "rows": table.rows}
                        for name, table in tables.items()
                    }
            for old in {*(self.folder / place).iterdir()}.difference(paths):
                old.unlink()
            outputs = tuple(str(path.relative_to(self.workspace.path)) for path in paths)
            self.workspace.write_record(self._stage(place), StageRecord(_inputs(held), outputs))
        return Outcome(self.folder, data, "\n".join(texts))

    def is_current(self, place: str) -> bool:
        """Whether what was written, of a category or of `ALL`, is still what there is to show."""
        record = self.workspace.record(self._stage(place))
        if record is None:
            return False
        seeds = {category: list(map(int, by_seed)) for category, by_seed in record.inputs["held"].items()}
        return self.workspace.is_current(self._stage(place), _inputs(self._held(seeds)))

    def _held(self, seeds: Mapping[str, Sequence[int]]) -> Held:
        return {category: judgements(self.workspace, self.name, category, own) for category, own in seeds.items()}

    def _of(self, category: str, held: HeldBySeed, protocol: Protocol) -> dict[str, Table]:
        """The tables of one category: over all parts, and part by part."""
        rows = CategoryRows(self.workspace, self.name, category, held, protocol)
        shown, more = rows.all(), MORE[protocol]
        run = _seeds(shown)
        dataset = self._dataset(category)
        reasons = [f"Not run: {row.name}: {row.reason}." for row in shown if row.reason]
        has_printed = any(row.printed is not None for row in shown)
        if isinstance(dataset, InputError):
            caption = self._caption(category, "no scans to judge by", run, protocol, has_printed)
            caption = caption.noting(f"{dataset.problem}.", *reasons)
            printed = next((row.printed for row in shown if row.printed is not None), None)
            if printed is None:
                return {"means": of_nothing(shown, caption)}
            structure = printed_structure(printed)
            return {"means": over_parts(shown, structure, caption), "parts": by_part(shown, structure, caption, more)}
        structure = dataset.structure
        of = objects_in_words(self.workspace, dataset)
        caption = self._caption(str(structure), of, run, protocol, has_printed)
        pairs = [rows.alike(titles) for titles in TABLES[self.name].compared]
        compared = [(pair[0], pair[1]) for pair in pairs if pair]
        notes = (*gaps(rows, structure), *seed_by_seed(rows, structure), *pseudo_labels(rows, shown), *reasons)
        summed = caption.noting(*notes, AGAINST if compared else "")
        return {
            "means": over_parts(shown, structure, summed, compared),
            "parts": by_part(shown, structure, caption, more),
        }

    def _over_categories(self, held: Held, protocol: Protocol) -> dict[str, Table]:
        """Means over categories. (The paper's own average degrees together with lengths.)"""
        datasets = {name: self._dataset(name) for name in held}
        structures = {name: found.structure for name, found in datasets.items() if isinstance(found, ScanDataset)}
        of_each = {name: CategoryRows(self.workspace, self.name, name, own, protocol) for name, own in held.items()}
        rows = {row.title: {category: own.row(row) for category, own in of_each.items()} for row in TABLES[self.name].rows}
        every = [row for by_category in rows.values() for row in by_category.values()]
        has_printed = any(row.printed is not None for row in every)
        caption = self._caption("means over categories", ", ".join(held), _seeds(every), protocol, has_printed)
        labelled = open_dataset(self.workspace).categories()
        absent = [name for name in TABLES[self.name].categories if not any(same_category(name, there) for there in labelled)]
        if absent:
            caption = caption.noting(f"Not run: {', '.join(absent)}: there are no labelled shapes.")
        return {"means": over_categories(rows, structures, caption)}

    def _caption(self, what: str, of: str, seeds: tuple[int, ...], protocol: Protocol, has_printed: bool) -> Caption:
        table = TABLES[self.name]
        caption = Caption(
            title=f"{table.title}{WAYS[protocol]}: {what}",
            data=f"{of} of workspace {self.workspace.root.absolute().name}",
            shapes=0,
            joints=0,
            split="test split by hashed id",
            seeds=seeds,
        )
        return caption.noting(table.note, AUTHORS_MEASURE if protocol == "kinmo" and has_printed else "")

    def _dataset(self, category: str) -> ScanDataset | InputError:
        """The scans of a category, or what is wrong with them: before there are any, or where scanning was stopped."""
        try:
            return open_scan_dataset(self.workspace, category)
        except InputError as error:
            return error

    def _stage(self, place: str) -> str:
        return f"table-{self.name}-{place}"


def _inputs(held: Held) -> dict[str, Any]:
    """What a table shows, as JSON has it, whose keys are text."""
    return {"held": {category: {str(seed): dict(rows) for seed, rows in by_seed.items()} for category, by_seed in held.items()}}


def _seeds(rows: Sequence[ScanRow]) -> tuple[int, ...]:
    return tuple(sorted({seed for row in rows for seed in row.seeds}))
