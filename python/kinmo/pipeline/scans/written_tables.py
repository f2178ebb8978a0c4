"""Tables 2, 3 and 4 of whatever was judged."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kinmo.categories import same_category
from kinmo.errors import InputError
from kinmo.evaluation.scan_labels import count_labels
from kinmo.evaluation.scan_records import ACCURACIES, Measure, read_scores
from kinmo.evaluation.scan_summary import change, gap_closed, measure_titles, measures_of
from kinmo.evaluation.scan_tables import (
    NOT_RUN,
    OUTDATED,
    ScanRow,
    by_part,
    of_nothing,
    over_categories,
    over_parts,
    printed_structure,
)
from kinmo.evaluation.tables import Caption, Table, as_text, write_table
from kinmo.pipeline.dataset import open_dataset
from kinmo.pipeline.evaluation_folder import ALL
from kinmo.pipeline.model_files import trained_on
from kinmo.pipeline.scans.dataset import (
    NO_FRAME,
    NO_SCAN,
    ScanDataset,
    open_scan_dataset,
    training_data,
)
from kinmo.pipeline.scans.networks import PROTOCOLS, Protocol
from kinmo.pipeline.scans.settings import PSEUDO_LABELLED
from kinmo.pipeline.scans.table_rows import TABLES, RowOf, printed_row
from kinmo.pipeline.stage import Outcome
from kinmo.scans.articulated_object import Structure
from kinmo.scans.scan_file import Role, count_objects
from kinmo.splits import Split
from kinmo.wording import counted
from kinmo.workspace import StageRecord, Workspace

WAYS: Mapping[Protocol, str] = {"kinmo": "", "ancsh": ", as ANCSH's public code measures"}
MORE: Mapping[Protocol, Sequence[Measure]] = {"kinmo": (), "ancsh": ACCURACIES}
"""What is measured besides, part by part."""
AUTHORS_MEASURE = "The authors' figures are of their data, and measured as --protocol ancsh measures."
AGAINST = (
    "Rows with the word against say by how much the first is above the second, over the seeds that both have, and the parts "
    "and joints of each frame that both have found."
)
ROLE_NAMES: Mapping[Role, str] = {"train": "labelled", "validation": "validation", "test": "test", "hidden": "held back"}
OTHER = "of other structures"
UNSEEN = {NO_FRAME: "that no frame shows all parts of", NO_SCAN: "that cannot be scanned (kinmo render says why)"}
LEAST, MOST = "supervised", "true labels"
"""Rows between which those with pseudo labels are: how far from the first to the second these go."""
NO_GAP = "(no sure gap)"
"""Stands for that share where true labels gain no more than chance could do."""


HeldBySeed = Mapping[int, Mapping[str, dict[str, Any] | None]]
"""By seed and row: what a judgement was made from, None for one that is not there or holds no more."""
Held = Mapping[str, HeldBySeed]
"""The same by category."""


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
        """The judgements that there are to show."""
        rows = TABLES[self.name].rows
        return {
            category: {seed: {row.title: row.judged(self.workspace, category, seed).held() for row in rows} for seed in own}
            for category, own in seeds.items()
        }

    def _of(self, category: str, by_seed: HeldBySeed, protocol: Protocol) -> dict[str, Table]:
        """The tables of one category: over all parts, and part by part."""
        rows = [self._row(row, category, by_seed, protocol) for row in TABLES[self.name].rows]
        run = _seeds(rows)
        dataset = self._dataset(category)
        reasons = [f"Not run: {row.name}: {row.reason}." for row in rows if row.reason]
        if dataset is None:
            caption = self._caption(category, "nothing is scanned yet", run, protocol)
            caption = caption.noting(*reasons)
            printed = next((row.printed for row in rows if row.printed is not None), None)
            if printed is None:
                return {"means": of_nothing(rows, caption)}
            structure = printed_structure(printed)
            return {"means": over_parts(rows, structure, caption), "parts": by_part(rows, structure, caption, MORE[protocol])}
        tests = open_dataset(self.workspace, category).labelled[Split.TEST]
        held_back = {entry.id for entry in tests if entry.is_held_back}
        caption = self._caption(str(dataset.structure), _objects_of(dataset, held_back), run, protocol)
        gaps = list(self._gaps(category, by_seed, dataset.structure, protocol))
        pairs = [self._alike(titles, category, by_seed, protocol) for titles in TABLES[self.name].compared]
        compared = [(pair[0], pair[1]) for pair in pairs if pair]
        seed_by_seed = self._seed_by_seed(category, by_seed, dataset.structure, protocol)
        labels = self._labels(rows, category)
        summed = caption.noting(*gaps, *seed_by_seed, *labels, *reasons, AGAINST if compared else "")
        return {
            "means": over_parts(rows, dataset.structure, summed, compared),
            "parts": by_part(rows, dataset.structure, caption, MORE[protocol]),
        }

    def _over_categories(self, held: Held, protocol: Protocol) -> dict[str, Table]:
        """Means over categories. (The paper's own average degrees together with lengths.)"""
        structures = {name: dataset.structure for name in held if (dataset := self._dataset(name)) is not None}
        rows = {
            row.title: {category: self._row(row, category, held[category], protocol) for category in held}
            for row in TABLES[self.name].rows
        }
        run = _seeds([row for by_category in rows.values() for row in by_category.values()])
        caption = self._caption("means over categories", ", ".join(held), run, protocol)
        labelled = open_dataset(self.workspace).categories()
        absent = [name for name in TABLES[self.name].categories if not any(same_category(name, there) for there in labelled)]
        if absent:
            caption = caption.noting(f"Not run: {', '.join(absent)}: there are no labelled shapes.")
        return {"means": over_categories(rows, structures, caption)}

    def _row(self, row: RowOf, category: str, by_seed: HeldBySeed, protocol: Protocol) -> ScanRow:
        judged = {seed: row.judged(self.workspace, category, seed) for seed in by_seed}
        seeds = tuple(seed for seed, held in by_seed.items() if held[row.title] is not None)
        objects = tuple(read_scores([judged[seed].scores(protocol) for seed in seeds]))
        is_outdated = any(each.scores(protocol).exists() for each in judged.values())
        missing = [seed for seed in by_seed if seed not in seeds]
        reason = next((reason for seed in missing if (reason := judged[seed].reason())), None)
        if reason and objects:
            reason = f"seeds {', '.join(map(str, missing))}: {reason}"
        return ScanRow(
            row.title,
            objects,
            printed_row(self.name, category, row.printed),
            seeds,
            OUTDATED if is_outdated else NOT_RUN,
            self._trained_on(row, category, seeds[0]) if objects else None,
            None if is_outdated and not objects else reason,
        )

    def _trained_on(self, row: RowOf, category: str, seed: int) -> str | None:
        """How many labelled objects networks were trained on, and how many that a setting has beside them."""
        weights = row.cell(category, seed).weights(row.workspace(self.workspace))
        if weights is None:
            return None
        labelled, others = trained_on(weights[0])
        return f"{labelled} + {others}" if others else str(labelled)

    def _alike(self, titles: Sequence[str], category: str, by_seed: HeldBySeed, protocol: Protocol) -> list[ScanRow]:
        """The rows of some titles, in their order, over the seeds that all were run for; none if there is no such seed."""
        rows = {row.title: row for row in TABLES[self.name].rows}
        whole = {seed: judged for seed, judged in by_seed.items() if all(judged.get(title) for title in titles)}
        return [self._row(rows[title], category, whole, protocol) for title in titles] if whole else []

    def _gaps(self, category: str, by_seed: HeldBySeed, structure: Structure, protocol: Protocol) -> Iterator[str]:
        """How far the pseudo labels of each row go from no labels to true ones."""
        known = {row.title for row in TABLES[self.name].rows}
        for row in TABLES[self.name].rows:
            is_between = row.setting in PSEUDO_LABELLED and {LEAST, MOST} <= known
            rows = self._alike((LEAST, row.title, MOST), category, by_seed, protocol) if is_between else []
            if rows:
                less, more, best = (each.objects for each in rows)
                shares = gap_closed(less, more, best, structure)
                if any(share is not None for share in shares):
                    told = [NO_GAP if share is None else f"{share:.0%}" for share in shares]
                    texts = (f"{title} {text}" for title, text in zip(measure_titles(structure), told, strict=True))
                    yield f"Share of the gap to true labels that pseudo labels close ({row.title}): {', '.join(texts)}."

    def _seed_by_seed(self, category: str, by_seed: HeldBySeed, structure: Structure, protocol: Protocol) -> Iterator[str]:
        """What one training has gained after another: intervals are over objects, and tell nothing of trainings."""
        for titles in TABLES[self.name].compared:
            pairs = (self._alike(titles, category, {seed: judged}, protocol) for seed, judged in by_seed.items())
            changes = [change(pair[0].objects, pair[1].objects, structure) for pair in pairs if pair]
            if len(changes) > 1:
                told = (
                    f"{measure.title} {', '.join(f'{each.value:+.{measure.decimals}f}' for each in seeds if each)}"
                    for measure, seeds in zip(measures_of(structure), zip(*changes, strict=True), strict=True)
                )
                yield f"{titles[1]} against {titles[0]}, seed by seed: {'; '.join(told)}."

    def _caption(self, what: str, of: str, seeds: tuple[int, ...], protocol: Protocol) -> Caption:
        table = TABLES[self.name]
        is_printed = any(row.printed for row in table.rows)
        caption = Caption(
            title=f"{table.title}{WAYS[protocol]}: {what}",
            data=f"{of} of workspace {self.workspace.root.absolute().name}",
            shapes=0,
            joints=0,
            split="test split by hashed id",
            seeds=seeds,
        )
        return caption.noting(table.note, AUTHORS_MEASURE if protocol == "kinmo" and is_printed else "")

    def _dataset(self, category: str) -> ScanDataset | None:
        """The scans of a category; None before there are any."""
        try:
            return open_scan_dataset(self.workspace, category)
        except InputError:
            return None

    def _labels(self, rows: Sequence[ScanRow], category: str) -> Iterator[str]:
        """Which method gave the pseudo labels that each row saw, and how right they are where the true ones were held back."""
        for row, shown in zip(TABLES[self.name].rows, rows, strict=True):
            if row.setting in PSEUDO_LABELLED and shown.objects:
                place = row.workspace(self.workspace)
                dataset = open_scan_dataset(place, category)
                if not row.cell(category, shown.seeds[0]).has_seen(place, training_data(dataset, dataset.beside(row.setting))):
                    yield f"Pseudo labels ({row.title}) are others now than those that the networks were trained on."
                    continue
                others = counted(dataset.left_out(row.setting), "object")
                left_out = f"left out: {others} that they give other joints, or none that can be seen."
                hidden, truths = dataset.files["hidden"], dataset.truths
                counts = count_labels(dataset.beside(row.setting), hidden, truths) if truths else ""
                yield f"Pseudo labels ({row.title}) are by --method {row.method}; {left_out} {counts}".rstrip()

    def _stage(self, place: str) -> str:
        return f"table-{self.name}-{place}"


def _inputs(held: Held) -> dict[str, Any]:
    """What a table shows, as JSON has it, whose keys are text."""
    return {"held": {category: {str(seed): dict(rows) for seed, rows in by_seed.items()} for category, by_seed in held.items()}}


def _seeds(rows: Sequence[ScanRow]) -> tuple[int, ...]:
    return tuple(sorted({seed for row in rows for seed in row.seeds}))


def _objects_of(dataset: ScanDataset, held_back: Collection[str]) -> str:
    """The category, how many objects train its networks, how many test them, those `held_back` (ids) among them, and how many
    are left out, by role and why.
    """
    training, tests = (count_objects(dataset.files[role]) for role in ("train", "test"))
    others = count_objects(file for file in dataset.files["test"] if file.id in held_back)
    text = f"{dataset.category}, {training} labelled objects to train on, {tests} to test on"
    text += f" ({others} of them held back)" if others else ""
    for what in (OTHER, *UNSEEN.values()):
        counts = Counter[str]()
        for (reason, role, _), count in dataset.others.items():
            counts[ROLE_NAMES.get(role, "")] += count * (UNSEEN.get(reason, OTHER) == what)
        left_out = [f"{counts[name]} {name}" for name in ROLE_NAMES.values() if counts[name]]
        text += f"; left out, {what}: {', '.join(left_out)}" if left_out else ""
    return text
