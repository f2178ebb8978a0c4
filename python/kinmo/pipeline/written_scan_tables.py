"""Tables 2, 3 and 4 of whatever was judged."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from kinmo.evaluation.scan_labels import count_labels
from kinmo.evaluation.scan_records import read_scores
from kinmo.evaluation.scan_tables import ScanRow, by_part, gap_closed, measure_titles, over_categories, over_parts
from kinmo.evaluation.tables import Caption, Table, as_text, write_table
from kinmo.pipeline.ancsh_files import PROTOCOLS, Protocol, scores_path, trained_cells
from kinmo.pipeline.evaluation_folder import ALL
from kinmo.pipeline.judged_scans import JudgedScans
from kinmo.pipeline.scan_dataset import ScanDataset, open_scan_dataset
from kinmo.pipeline.scan_table_rows import TABLES, RowOf, printed_row
from kinmo.pipeline.stage import Outcome
from kinmo.scans.articulated_object import Structure
from kinmo.scans.scan_file import count_objects
from kinmo.workspace import Workspace, write_text_atomically

WAYS: Mapping[Protocol, str] = {"kinmo": "", "ancsh": ", as ANCSH's public code measures"}


@dataclass(frozen=True)
class WrittenTables:
    """A table (`scan_table_rows.TABLES`), a category at a time. Rows that were not run say so."""

    workspace: Workspace
    name: str

    @property
    def folder(self) -> Path:
        """Where it is written, a folder a category."""
        return self.workspace.evaluation / f"table-{self.name}"

    def write(self, seeds: Mapping[str, Sequence[int]], shown: Protocol = "kinmo") -> Outcome:
        """Write it for the categories of `seeds`, by each protocol; the text is that of the one to be `shown`."""
        texts, data = [], {}
        for place, protocol, tables in self._all(seeds):
            for name, table in tables.items():
                write_table(table, self.folder / place, name if protocol == "kinmo" else f"{name}_{protocol}")
            if protocol == shown:
                texts += [as_text(table) for table in tables.values()]
                data[place] = {
                    name: {"columns": [column.title for column in table.columns], "rows": table.rows}
                    for name, table in tables.items()
                }
        write_text_atomically(self.folder / "table.json", json.dumps(data, indent=1, ensure_ascii=False) + "\n")
        return Outcome(self.folder, data, "\n".join(texts))

    def _all(self, seeds: Mapping[str, Sequence[int]]) -> Iterator[tuple[str, Protocol, dict[str, Table]]]:
        """The tables by category and protocol, and those of all categories where there are several."""
        for category, own in seeds.items():
            for protocol in PROTOCOLS:
                yield category, protocol, self.of(category, own, protocol)
        if len(seeds) > 1:
            for protocol in PROTOCOLS:
                yield ALL, protocol, {"means": self.over_categories(seeds, protocol)}

    def of(self, category: str, seeds: Sequence[int], protocol: Protocol = "kinmo") -> dict[str, Table]:
        """The tables of one category: part by part, and over all parts."""
        dataset = open_scan_dataset(self.workspace, category)
        rows = [self._row(row, category, seeds, protocol) for row in TABLES[self.name].rows]
        caption = self._caption(str(dataset.structure), _objects_of(dataset), self._seeds_run(category, seeds), protocol)
        notes = [caption.note, _gaps(rows, dataset.structure), _labels(rows, dataset)]
        summed = replace(caption, note=" ".join(filter(None, notes)))
        return {"parts": by_part(rows, dataset.structure, caption), "means": over_parts(rows, dataset.structure, summed)}

    def is_current(self, category: str) -> bool:
        """Whether nothing has changed since its figures were measured."""
        for row in TABLES[self.name].rows:
            place = row.workspace(self.workspace)
            cells = [cell for cell in trained_cells(place) if (cell.category, cell.setting) == (category, row.setting)]
            shown = (cell for cell in cells if self._scores(row, category, cell.seed).exists())
            if not all(JudgedScans(place, cell, row.on_rough).is_current() for cell in shown):
                return False
        return True

    def over_categories(self, seeds: Mapping[str, Sequence[int]], protocol: Protocol = "kinmo") -> Table:
        """Means over the categories of `seeds`. (The paper's own average degrees together with lengths.)"""
        structures = {category: open_scan_dataset(self.workspace, category).structure for category in seeds}
        rows = {
            row.title: {category: self._row(row, category, own, protocol).objects for category, own in seeds.items()}
            for row in TABLES[self.name].rows
        }
        run = tuple(sorted({seed for category, own in seeds.items() for seed in self._seeds_run(category, own)}))
        return over_categories(rows, structures, self._caption("means over categories", ", ".join(seeds), run, protocol))

    def _caption(self, what: str, of: str, seeds: tuple[int, ...], protocol: Protocol) -> Caption:
        table = TABLES[self.name]
        return Caption(
            title=f"{table.title}{WAYS[protocol]}: {what}",
            data=f"{of} of workspace {self.workspace.root.absolute().name}",
            shapes=0,
            joints=0,
            split="test split by hashed id",
            seeds=seeds,
            note=table.note,
        )

    def _row(self, row: RowOf, category: str, seeds: Sequence[int], protocol: Protocol) -> ScanRow:
        paths = (self._scores(row, category, seed, protocol) for seed in seeds)
        objects = read_scores([path for path in paths if path.exists()])
        return ScanRow(row.title, tuple(objects), printed_row(self.name, category, row.printed))

    def _scores(self, row: RowOf, category: str, seed: int, protocol: Protocol = "kinmo") -> Path:
        return scores_path(row.workspace(self.workspace), row.cell(category, seed), row.on_rough, protocol)

    def _seeds_run(self, category: str, seeds: Sequence[int]) -> tuple[int, ...]:
        rows = TABLES[self.name].rows
        return tuple(seed for seed in seeds if any(self._scores(row, category, seed).exists() for row in rows))


def _objects_of(dataset: ScanDataset) -> str:
    """The category, how many objects train its networks, and how many of other structures are left out."""
    left_out = Counter[str]()
    for (_, role), count in dataset.others.items():
        left_out[role] += count
    training, others = count_objects(dataset.files["train"]), left_out["train"]
    return (
        f"{dataset.category}, {training} labelled objects to train on ({others} of other structures are not, "
        f"nor are {left_out['test']} test objects)"
    )


def _labels(rows: Sequence[ScanRow], dataset: ScanDataset) -> str:
    """How right the pseudo labels are that the rows saw, where the true ones were held back."""
    seen = any(row.name == "semi-weakly" and row.objects for row in rows)
    return str(count_labels(dataset.beside("semi-weakly"), dataset.files["hidden"])) if seen and dataset.files["hidden"] else ""


def _gaps(rows: Sequence[ScanRow], structure: Structure) -> str:
    """How far pseudo labels go from no labels to true ones, where all three were run."""
    named = {row.name: row.objects for row in rows}
    less, more, best = (named.get(name, ()) for name in ("supervised", "semi-weakly", "true labels"))
    if not (less and more and best):
        return ""
    shares = gap_closed(less, more, best, structure)
    texts = [
        f"{title} {share:.0%}" for title, share in zip(measure_titles(structure), shares, strict=True) if share is not None
    ]
    return f"Share of the gap to true labels that pseudo labels close: {', '.join(texts)}." if texts else ""
