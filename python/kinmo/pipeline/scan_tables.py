"""Tables 2, 3 and 4 of the paper, cell by cell: what each is of, what has to be done for it, and what it says."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from kinmo.categories import same_category
from kinmo.config import load_config
from kinmo.errors import InputError, did_you_mean
from kinmo.evaluation.paper_tables import paper_tables
from kinmo.evaluation.scan_records import read_scores
from kinmo.evaluation.scan_tables import ScanRow, by_part, gap_closed, measure_titles, over_parts
from kinmo.evaluation.tables import Caption, Table, as_text, write_table
from kinmo.pipeline.ancsh_files import Cell, scores_path, trained_cells
from kinmo.pipeline.dataset import open_dataset
from kinmo.pipeline.evaluate_scans import EvaluateScans
from kinmo.pipeline.pseudo_label import PseudoLabel
from kinmo.pipeline.render import Render
from kinmo.pipeline.scan_dataset import PAPER_CATEGORIES, Setting, open_scan_dataset
from kinmo.pipeline.stage import Observer, Outcome, Plan, Stage
from kinmo.pipeline.train import Train
from kinmo.pipeline.train_ancsh import TrainAncsh, training_seconds
from kinmo.scans.articulated_object import Structure
from kinmo.splits import Split
from kinmo.workspace import Workspace, write_text_atomically

SHARES = (1.0, 0.8, 0.5, 0.3)
"""Of the labelled shapes, in Table 3."""
MANY_SEEDS = ("Refrigerator", "Scissors")
"""Categories whose cells have three seeds by default."""


@dataclass(frozen=True)
class RowOf:
    """A row of a table: networks of a `setting`, with a share of the labels, and what the paper calls it, if it has it."""

    title: str
    setting: Setting
    labels: float = 1.0
    printed: str = ""


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


@dataclass(frozen=True)
class MakeTable:
    """Do what is missing of a table, a category and a cell at a time, and write it.

    With `hours`, no cell is begun that would not be done by then; cells that are not run are shown as such. Without a category
    it is of those of the paper's that there are labelled shapes of. `seeds` None means three for `MANY_SEEDS`, else one.
    """

    number: int
    workspace: Workspace
    config: str
    method: str
    category: str | None = None
    seeds: int | None = None
    hours: float | None = None
    seed: int = 0
    device: str = "auto"
    workers: int = 1

    def plan(self) -> Plan:
        steps, seconds = [], 0.0
        for category in self._categories():
            for row, cell in self._cells(category):
                if not is_judged(self._workspace(row), cell):
                    expected = self._seconds()
                    steps.append(f"{cell}, {row.labels:.0%} of the labels: render, train, judge")
                    seconds += expected
        return Plan(tuple(steps), seconds)

    def run(self, observer: Observer) -> Outcome:
        begun, limit = time.monotonic(), float("inf") if self.hours is None else 3600.0 * self.hours
        took: list[float] = []
        for category in self._categories():
            for row, cell in self._cells(category):
                expected = max(took, default=self._seconds())
                if not is_judged(self._workspace(row), cell) and time.monotonic() - begun + expected > limit:
                    observer.note(f"not run: {cell}, {row.labels:.0%} of the labels: it would take longer than --hours")
                    continue
                start = time.monotonic()
                observer.note(f"{cell}, {row.labels:.0%} of the labels")
                for stage in self._stages(row, cell):
                    stage.run(observer)
                if (spent := time.monotonic() - start) > 0.1 * expected:
                    took.append(spent)
        return write_tables(self.workspace, self.number, self._categories(), self._seeds_of)

    def _categories(self) -> tuple[str, ...]:
        table, dataset = TABLES[self.number], open_dataset(self.workspace)
        known = dataset.categories()
        wanted = table.categories if self.category is None else (self.category,)
        found = tuple(name for want in wanted for name in known if same_category(name, want))
        if not found:
            near = did_you_mean(self.category or "", known)
            problem = f"no labelled shapes of {' or '.join(wanted)}{near}; there are {', '.join(known)}"
            raise InputError(self.workspace.prepared, problem)
        return found

    def _seeds_of(self, category: str) -> tuple[int, ...]:
        count = self.seeds or (3 if any(same_category(category, name) for name in MANY_SEEDS) else 1)
        return tuple(range(self.seed, self.seed + count))

    def _cells(self, category: str) -> Iterator[tuple[RowOf, Cell]]:
        """The rows of the first seed, then those of the next: what is cut off leaves whole comparisons."""
        for seed in self._seeds_of(category):
            for row in TABLES[self.number].rows:
                yield row, Cell(category, row.setting, seed)

    def _workspace(self, row: RowOf) -> Workspace:
        return Workspace(self.workspace.root, row.labels)

    def _stages(self, row: RowOf, cell: Cell) -> Iterator[Stage]:
        place = self._workspace(row)
        if row.setting in ("semi-weakly", "dsg-net"):
            yield Train(self.method, place, self.config, None, self.seed, self.device, self.workers)
            yield PseudoLabel(place, self.method, cell.category, None, self.device, self.workers)
        yield Render(place, self.config, cell.category, self.seed, self.workers, unlabelled=row.setting == "semi")
        yield TrainAncsh(place, self.config, cell.category, cell.setting, cell.seed, self.device, self.workers)
        yield EvaluateScans(place, cell, self.device)

    def _seconds(self) -> float:
        """About how long a cell takes, until one was run."""
        return training_seconds(load_config(self.config).ancsh, self.workers)


@dataclass(frozen=True)
class JudgeTrained:
    """Judge whatever networks are trained for scans, and write the tables that they have a cell in.

    Without a category those of all categories.
    """

    workspace: Workspace
    category: str | None = None
    device: str = "auto"

    def plan(self) -> Plan:
        plans = [EvaluateScans(place, cell, self.device).plan() for place, cell in self._cells()]
        return Plan(tuple(step for plan in plans for step in plan.steps), sum(plan.seconds for plan in plans))

    def run(self, observer: Observer) -> Outcome:
        cells = list(self._cells())
        for place, cell in cells:
            EvaluateScans(place, cell, self.device).run(observer)
        texts, data = [], {}
        for number, table in TABLES.items():
            rows = {(row.setting, row.labels) for row in table.rows}
            own = [cell for place, cell in cells if (cell.setting, place.labels) in rows]
            # a category that the paper has no table of is shown in the first of them
            own = [cell for cell in own if number == min(TABLES) or _is_printed(table, cell.category)]
            if own:
                seeds = {name: sorted({cell.seed for cell in own if cell.category == name}) for name in _categories(own)}
                outcome = write_tables(self.workspace, number, list(seeds), seeds.__getitem__)
                texts.append(outcome.text)
                data[f"table{number}"] = outcome.data
        return Outcome(self.workspace.evaluation, data, "\n".join(texts))

    def _cells(self) -> Iterator[tuple[Workspace, Cell]]:
        for share in SHARES:
            place = Workspace(self.workspace.root, share)
            for cell in trained_cells(place):
                if self.category is None or same_category(cell.category, self.category):
                    yield place, cell


def _is_printed(table: ScanTable, category: str) -> bool:
    return any(same_category(category, name) for name in table.categories)


def _categories(cells: Sequence[Cell]) -> list[str]:
    return sorted({cell.category for cell in cells})


def is_judged(workspace: Workspace, cell: Cell) -> bool:
    """Whether there are scores of a cell."""
    return scores_path(workspace, cell).exists()


def table_folder(workspace: Workspace, number: int) -> Path:
    """Where a table is written, a folder a category."""
    return workspace.evaluation / f"table{number}"


def write_tables(
    workspace: Workspace, number: int, categories: Sequence[str], seeds_of: Callable[[str], Sequence[int]]
) -> Outcome:
    """Write a table of what was judged, for each of some categories; the rows that were not run say so."""
    texts, data = [], {}
    folder = table_folder(workspace, number)
    for category in categories:
        tables = tables_of(workspace, number, category, seeds_of(category))
        for name, table in tables.items():
            write_table(table, folder / category, name)
        texts += [as_text(table) for table in tables.values()]
        data[category] = {name: {"columns": [c.title for c in t.columns], "rows": t.rows} for name, t in tables.items()}
    write_text_atomically(folder / "table.json", json.dumps(data, indent=1, ensure_ascii=False) + "\n")
    return Outcome(folder, data, "\n".join(texts))


def tables_of(workspace: Workspace, number: int, category: str, seeds: Sequence[int]) -> dict[str, Table]:
    """The tables of one category: part by part, and over all parts."""
    table = TABLES[number]
    structure = open_scan_dataset(workspace, category).structure
    rows = [_row(workspace, number, row, category, seeds) for row in table.rows]
    dataset = open_dataset(workspace, category)
    count = len(dataset.labelled[Split.TRAIN])
    data = f"{category} of workspace {workspace.root.absolute().name}, {count} labelled shapes to train on"
    seeds_run = tuple(
        sorted({seed for row in table.rows for seed in seeds if is_judged(_place(workspace, row), _cell(row, category, seed))})
    )
    caption = Caption(
        f"Table {number}, {table.title}: {structure}", data, 0, 0, "test split by hashed id", seeds_run, table.note
    )
    found = {"parts": by_part(rows, structure, caption), "means": over_parts(rows, structure, caption)}
    gaps = _gaps(rows, structure)
    if gaps:
        means = found["means"]
        found["means"] = replace(
            means, caption=replace(caption, note=f"{means.caption.note} {gaps}", shapes=means.caption.shapes)
        )
    return found


def _row(workspace: Workspace, number: int, row: RowOf, category: str, seeds: Sequence[int]) -> ScanRow:
    place = _place(workspace, row)
    paths = [scores_path(place, _cell(row, category, seed)) for seed in seeds]
    objects = read_scores([path for path in paths if path.exists()])
    return ScanRow(row.title, tuple(objects), printed_row(number, category, row.printed))


def _place(workspace: Workspace, row: RowOf) -> Workspace:
    return Workspace(workspace.root, row.labels)


def _cell(row: RowOf, category: str, seed: int) -> Cell:
    return Cell(category, row.setting, seed)


def printed_row(number: int, category: str, name: str) -> list[list[float | None]] | None:
    """What the paper prints in a row of a table; None where it has no such row."""
    for known, rows in paper_tables()[f"table{number}"]["categories"].items():
        if same_category(known, category):
            found: list[list[float | None]] | None = rows.get(name)
            return found
    return None


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
