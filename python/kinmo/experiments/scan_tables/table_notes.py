"""Notes below the tables of scans of one category."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

from kinmo.core.wording import counted
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.scan_tables.category_rows import CategoryRows
from kinmo.experiments.scan_tables.pseudo_label_truth import count_labels
from kinmo.experiments.scan_tables.scan_summary import change, gap_closed, measure_titles, measures_of
from kinmo.experiments.scan_tables.scan_table_layout import ScanRow
from kinmo.experiments.scan_tables.table_rows import TABLES, TableRow
from kinmo.pipeline.scans.scan_dataset import NO_FRAME, NO_SCAN, ScanDataset, open_scan_dataset, training_data
from kinmo.scans.files.scan_file import Role, ScanFile, count_objects
from kinmo.scans.object_structure import Structure

ROLE_NAMES: Mapping[Role, str] = {"train": "labelled", "validation": "validation", "test": "test", "oracle": "oracle"}
OTHER = "with other structures"
NOT_SEEN = {NO_FRAME: "without a frame that shows all parts", NO_SCAN: "that cannot be scanned (kinmo render says why)"}
SUPERVISED, ORACLE = "supervised", "oracle labels"
"""Rows that bound the gap that pseudo labels can close."""
NO_GAP = "(no sure gap)"
"""Stands for the closed share where oracle labels gain no more than chance."""


def objects_in_words(workspace: Workspace, dataset: ScanDataset) -> str:
    """Category, numbers of training and test objects, and numbers of objects that are not used, with the reasons."""
    oracle = {entry.id for entry in open_dataset(workspace, dataset.category).labelled[Split.TEST] if entry.is_oracle}
    training, tests = (count_objects(dataset.files[role]) for role in ("train", "test"))
    others = count_objects(file for file in dataset.files["test"] if file.id in oracle)
    text = f"{dataset.category}, {training} labelled training objects, {tests} test objects"
    text += f" ({others} of them with oracle labels)" if others else ""
    for what in (OTHER, *NOT_SEEN.values()):
        counts = Counter[str]()
        for (reason, role, _), count in dataset.others.items():
            counts[ROLE_NAMES.get(role, "")] += count * (NOT_SEEN.get(reason, OTHER) == what)
        skipped = [f"{counts[name]} {name}" for name in ROLE_NAMES.values() if counts[name]]
        text += f"; skipped {what}: {', '.join(skipped)}" if skipped else ""
    return text


def gaps(rows: CategoryRows, structure: Structure) -> Iterator[str]:
    """Share of the gap between no labels and oracle labels that the pseudo labels of each row close."""
    table = TABLES[rows.name]
    if not {SUPERVISED, ORACLE} <= {row.title for row in table.rows}:
        return
    for row in table.rows:
        three = rows.comparable((SUPERVISED, row.title, ORACLE)) if row.setting == "semi-weakly" else []
        if three:
            less, more, best = (own.objects for own in three)
            shares = gap_closed(less, more, best, structure)
            if any(share is not None for share in shares):
                texts = [NO_GAP if share is None else f"{share:.0%}" for share in shares]
                pairs = (f"{title} {text}" for title, text in zip(measure_titles(structure), texts, strict=True))
                yield f"Share of the gap to oracle labels that pseudo labels close ({row.title}): {', '.join(pairs)}."


def seed_by_seed(rows: CategoryRows, structure: Structure) -> Iterator[str]:
    """Differences of compared rows for each seed: intervals are over objects, and do not cover the spread of trainings."""
    for titles in TABLES[rows.name].compared:
        pairs = [pair for own in rows.by_seed() if (pair := own.comparable(titles))]
        changes = [change(before.objects, after.objects, structure) for before, after in pairs]
        if len(changes) > 1:
            texts = (
                f"{measure.title} {', '.join(f'{each.value:+.{measure.decimals}f}' for each in seeds if each)}"
                for measure, seeds in zip(measures_of(structure), zip(*changes, strict=True), strict=True)
            )
            yield f"{titles[1]} against {titles[0]}, seed by seed: {'; '.join(texts)}."


def pseudo_labels(rows: CategoryRows, shown: Sequence[ScanRow]) -> Iterator[str]:
    """Method of the pseudo labels of each row, and how many are right where oracle labels are known.

    Args:
        rows: The rows.
        shown: The same rows with their scores, in the same order.
    """
    titles: dict[str, list[str]] = {}
    for row, its in zip(TABLES[rows.name].rows, shown, strict=True):
        if row.setting == "semi-weakly" and its.objects:
            titles.setdefault(_truth_of_labels(rows, row, its.seeds), []).append(row.title)
    return (f"Pseudo labels ({'; '.join(own)}) are {text}" for text, own in titles.items())


def _truth_of_labels(rows: CategoryRows, row: TableRow, seeds: Sequence[int]) -> str:
    place = row.variant.workspace(rows.workspace)
    dataset = open_scan_dataset(place, rows.category, row.method)
    extra = dataset.extra(row.setting)
    data = training_data(dataset, extra)
    others = [seed for seed in seeds if not row.run(rows.category, seed).was_trained_on(place, data)]
    if others:
        which = "the networks" if len(others) == len(seeds) else f"networks of seeds {', '.join(map(str, others))}"
        return f"newer than those that {which} were trained on."
    unlike = counted(dataset.count_other_structures(), "object")
    skipped = f"skipped: {unlike} with other predicted joints, or without a usable frame."
    counts = ""
    if dataset.oracle_ids:
        counts = str(count_labels(extra, _oracle_of(place, dataset), dataset.oracle_ids))
    return f"by --method {row.method}; {skipped} {counts}".rstrip()


def _oracle_of(workspace: Workspace, dataset: ScanDataset) -> list[ScanFile]:
    """Objects with oracle labels that unlabelled shapes are, or are copies of."""
    unlabelled = open_dataset(workspace, dataset.category).unlabelled
    originals = {dataset.oracle_ids.get((entry.id, entry.layout)) for entry in unlabelled}
    return [file for file in dataset.files["oracle"] if file.id in originals]
