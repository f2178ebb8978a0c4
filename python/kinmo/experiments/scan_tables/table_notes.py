"""What Tables 2, 3 and 4 say of one category beside their figures."""

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
from kinmo.experiments.scan_tables.table_rows import TABLES, RowOf
from kinmo.pipeline.scans.scan_dataset import NO_FRAME, NO_SCAN, ScanDataset, open_scan_dataset, training_data
from kinmo.pipeline.scans.training_settings import PSEUDO_LABELLED, Setting, is_pseudo_labelled_for
from kinmo.scans.articulated_object import Structure
from kinmo.scans.scan_file import Role, ScanFile, count_objects

ROLE_NAMES: Mapping[Role, str] = {"train": "labelled", "validation": "validation", "test": "test", "hidden": "held back"}
OTHER = "of other structures"
UNSEEN = {NO_FRAME: "that no frame shows all parts of", NO_SCAN: "that cannot be scanned (kinmo render says why)"}
LEAST, MOST = "supervised", "true labels"
"""Rows between which those with pseudo labels are: how far from the first to the second these go."""
NO_GAP = "(no sure gap)"
"""Stands for that share where true labels gain no more than chance could do."""


def objects_in_words(workspace: Workspace, dataset: ScanDataset) -> str:
    """The category, how many objects train its networks, how many test them, held back ones among them, and how many are left
    out, by role and why.
    """
    held_back = {entry.id for entry in open_dataset(workspace, dataset.category).labelled[Split.TEST] if entry.is_held_back}
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


def gaps(rows: CategoryRows, structure: Structure) -> Iterator[str]:
    """How far the pseudo labels of each row go from no labels to true ones."""
    table = TABLES[rows.name]
    if not {LEAST, MOST} <= {row.title for row in table.rows}:
        return
    for row in table.rows:
        three = rows.alike((LEAST, row.title, MOST)) if row.setting in PSEUDO_LABELLED else []
        if three:
            less, more, best = (each.objects for each in three)
            shares = gap_closed(less, more, best, structure)
            if any(share is not None for share in shares):
                told = [NO_GAP if share is None else f"{share:.0%}" for share in shares]
                texts = (f"{title} {text}" for title, text in zip(measure_titles(structure), told, strict=True))
                yield f"Share of the gap to true labels that pseudo labels close ({row.title}): {', '.join(texts)}."


def seed_by_seed(rows: CategoryRows, structure: Structure) -> Iterator[str]:
    """What one training has gained after another: intervals are over objects, and tell nothing of trainings."""
    for titles in TABLES[rows.name].compared:
        pairs = [pair for own in rows.of_each_seed() if (pair := own.alike(titles))]
        changes = [change(before.objects, after.objects, structure) for before, after in pairs]
        if len(changes) > 1:
            told = (
                f"{measure.title} {', '.join(f'{each.value:+.{measure.decimals}f}' for each in seeds if each)}"
                for measure, seeds in zip(measures_of(structure), zip(*changes, strict=True), strict=True)
            )
            yield f"{titles[1]} against {titles[0]}, seed by seed: {'; '.join(told)}."


def pseudo_labels(rows: CategoryRows, shown: Sequence[ScanRow]) -> Iterator[str]:
    """Which method gave the pseudo labels that each of the rows, `shown`, saw, and how right they are where the true ones were
    held back. What is the same of several rows is said once.
    """
    titles: dict[str, list[str]] = {}
    for row, its in zip(TABLES[rows.name].rows, shown, strict=True):
        if row.setting in PSEUDO_LABELLED and its.objects:
            titles.setdefault(_of_labels(rows, row, its.seeds), []).append(row.title)
    return (f"Pseudo labels ({'; '.join(of)}) are {text}" for text, of in titles.items())


def _of_labels(rows: CategoryRows, row: RowOf, seeds: Sequence[int]) -> str:
    place = row.workspace(rows.workspace)
    dataset = open_scan_dataset(place, rows.category)
    labelled = training_data(dataset, dataset.beside(row.setting))
    others = [seed for seed in seeds if not row.cell(rows.category, seed).has_seen(place, labelled)]
    if others:
        which = "the networks" if len(others) == len(seeds) else f"networks of seeds {', '.join(map(str, others))}"
        return f"others now than those that {which} were trained on."
    unlike = counted(dataset.left_out(row.setting), "object")
    left_out = f"left out: {unlike} that they give other joints, or none that can be seen."
    counts = ""
    if dataset.truths:
        counts = str(count_labels(dataset.beside(row.setting), _to_label(place, dataset, row.setting), dataset.truths))
    return f"by --method {row.method}; {left_out} {counts}".rstrip()


def _to_label(workspace: Workspace, dataset: ScanDataset, setting: Setting) -> list[ScanFile]:
    """Hidden objects that a setting's shapes without labels are, or are copies of."""
    unlabelled = open_dataset(workspace, dataset.category).unlabelled
    shapes = [(entry.id, entry.layout) for entry in unlabelled if is_pseudo_labelled_for(setting, entry.layout)]
    originals = {dataset.truths.get(shape) for shape in shapes}
    return [file for file in dataset.files["hidden"] if file.id in originals]
