"""Tables 2, 3 and 4 of whatever was judged."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from kinmo.evaluation.scan_records import read_scores
from kinmo.evaluation.scan_tables import ScanRow, by_part, gap_closed, measure_titles, over_parts
from kinmo.evaluation.tables import Caption, Table, as_text, write_table
from kinmo.pipeline.ancsh_files import PROTOCOLS, Protocol, scores_path
from kinmo.pipeline.dataset import open_dataset
from kinmo.pipeline.scan_dataset import open_scan_dataset
from kinmo.pipeline.scan_table_rows import TABLES, RowOf, printed_row
from kinmo.pipeline.stage import Outcome
from kinmo.scans.articulated_object import Structure
from kinmo.splits import Split
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
        for category, own in seeds.items():
            for protocol in PROTOCOLS:
                tables = self.of(category, own, protocol)
                for name, table in tables.items():
                    write_table(table, self.folder / category, name if protocol == "kinmo" else f"{name}_{protocol}")
                if protocol == shown:
                    texts += [as_text(table) for table in tables.values()]
                    data[category] = {
                        name: {"columns": [column.title for column in table.columns], "rows": table.rows}
                        for name, table in tables.items()
                    }
        write_text_atomically(self.folder / "table.json", json.dumps(data, indent=1, ensure_ascii=False) + "\n")
        return Outcome(self.folder, data, "\n".join(texts))

    def of(self, category: str, seeds: Sequence[int], protocol: Protocol = "kinmo") -> dict[str, Table]:
        """The tables of one category: part by part, and over all parts."""
        table = TABLES[self.name]
        structure = open_scan_dataset(self.workspace, category).structure
        rows = [self._row(row, category, seeds, protocol) for row in table.rows]
        count = len(open_dataset(self.workspace, category).labelled[Split.TRAIN])
        caption = Caption(
            title=f"{table.title}{WAYS[protocol]}: {structure}",
            data=f"{category} of workspace {self.workspace.root.absolute().name}, {count} labelled shapes to train on",
            shapes=0,
            joints=0,
            split="test split by hashed id",
            seeds=self._seeds_run(category, seeds),
            note=table.note,
        )
        summed = replace(caption, note=" ".join(filter(None, [caption.note, _gaps(rows, structure)])))
        return {"parts": by_part(rows, structure, caption), "means": over_parts(rows, structure, summed)}

    def _row(self, row: RowOf, category: str, seeds: Sequence[int], protocol: Protocol) -> ScanRow:
        paths = (self._scores(row, category, seed, protocol) for seed in seeds)
        objects = read_scores([path for path in paths if path.exists()])
        return ScanRow(row.title, tuple(objects), printed_row(self.name, category, row.printed))

    def _scores(self, row: RowOf, category: str, seed: int, protocol: Protocol = "kinmo") -> Path:
        return scores_path(row.workspace(self.workspace), row.cell(category, seed), row.on_rough, protocol)

    def _seeds_run(self, category: str, seeds: Sequence[int]) -> tuple[int, ...]:
        rows = TABLES[self.name].rows
        return tuple(seed for seed in seeds if any(self._scores(row, category, seed).exists() for row in rows))


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
