"""Notes below the tables of scans of one category, such as the accuracy of pseudo labels by oracle labels."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from kinmo.core.wording import counted
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.workspace import Workspace
from kinmo.evaluation import metrics
from kinmo.evaluation.scan_records import change, gap_closed, measures_of
from kinmo.experiments.scan_tables.category_rows import CategoryRows
from kinmo.experiments.scan_tables.scan_table_layout import ScanRow
from kinmo.experiments.scan_tables.table_rows import TABLES, TableRow
from kinmo.pipeline.scans.scan_dataset import NO_FRAME, NO_SCAN, ScanDataset, open_scan_dataset, training_data
from kinmo.scans.files.scan_file import Role, ScanFile, count_objects
from kinmo.scans.object_structure import Structure

ROLE_NAMES: Mapping[Role, str] = {"train": "labelled", "validation": "validation", "test": "test", "oracle": "oracle"}
OTHER = "with other structures"
NOT_SEEN = {NO_FRAME: "without a frame that shows all parts", NO_SCAN: "that cannot be scanned (kinmo render says why)"}
SUPERVISED, ORACLE = "supervised", "oracle labels"  # rows that bound the gap that pseudo labels can close
NO_GAP = "(no sure gap)"  # stands for the closed share where oracle labels gain no more than chance


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
            if any(share is not None for share in shares.values()):
                texts = (f"{title} {NO_GAP if share is None else f'{share:.0%}'}" for title, share in shares.items())
                yield f"Share of the gap to oracle labels that pseudo labels close ({row.title}): {', '.join(texts)}."


def seed_by_seed(rows: CategoryRows, structure: Structure) -> Iterator[str]:
    """Differences of compared rows for each seed: intervals are over objects, and do not cover the spread of trainings."""
    for titles in TABLES[rows.name].compared:
        pairs = [pair for own in rows.by_seed() if (pair := own.comparable(titles))]
        changes = [change(before.objects, after.objects, structure) for before, after in pairs]
        if len(changes) > 1:
            texts = []
            for measure in measures_of(structure):
                known = filter(None, (seed[measure.title] for seed in changes))
                texts.append(f"{measure.title} {', '.join(f'{each.value:+.{measure.decimals}f}' for each in known)}")
            yield f"{titles[1]} against {titles[0]}, seed by seed: {'; '.join(texts)}."


def pseudo_labels(rows: CategoryRows, shown: Sequence[ScanRow]) -> Iterator[str]:
    """Method of the pseudo labels of each row, and how many are right where oracle labels are known.

    `shown` are all rows with their scores.
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
    counts = count_labels(extra, _oracle_of(place, dataset), dataset.oracle_ids) if dataset.oracle_ids else ""
    return f"by --method {row.method}; {skipped} {counts}".rstrip()


def _oracle_of(workspace: Workspace, dataset: ScanDataset) -> list[ScanFile]:
    """Objects with oracle labels that unlabelled shapes are, or are copies of."""
    unlabelled = open_dataset(workspace, dataset.category).unlabelled
    originals = {dataset.oracle_ids.get((entry.id, entry.layout)) for entry in unlabelled}
    return [file for file in dataset.files["oracle"] if file.id in originals]


@dataclass(frozen=True)
class LabelCounts:
    """Numbers of pseudo-labelled objects of one structure."""

    labelled: int  # objects with this structure by their pseudo labels, and with oracle labels
    right_structure: int  # those of them that truly have this structure
    right_axes: int  # those of these with the right directions of all axes
    right_lines: int  # those of these with all axes in the right places too
    true: int  # objects with this structure by their oracle labels, pseudo-labelled or not
    unknown: int = 0  # objects with this structure by their pseudo labels, but without oracle labels

    def __str__(self) -> str:
        if not self.labelled and self.unknown:
            return f"Pseudo labels give {counted(self.unknown, 'object')} these joints; there are no oracle labels for them."
        text = (
            f"Of {self.labelled} objects that pseudo labels give these joints, {self.right_structure} truly have them, "
            f"{self.right_axes} with the right directions of all axes ({math.degrees(metrics.MAX_AXIS_ERROR):g} degrees), "
            f"{self.right_lines} with all axes in the right places too ({metrics.MAX_LINE_DISTANCE:g} diagonals). "
            f"In all, {self.true} truly have these joints."
        )
        return f"{text} Another {self.unknown} have no oracle labels." if self.unknown else text


def count_labels(
    pseudo: Sequence[ScanFile], oracle: Sequence[ScanFile], oracle_ids: Mapping[tuple[str, str], str]
) -> LabelCounts:
    """Compare scans by pseudo labels with scans by oracle labels. All have the same structure; variants do not count.

    `oracle_ids` has the id of the shape with the oracle label by `ScanFile.object` (`ScanDataset.oracle_ids`). An object whose
    oracle label is not among `oracle` truly has another structure.
    """
    labelled = {file.object: file for file in pseudo if not file.provenance.variant}
    truths = {file.id: file for file in oracle if not file.provenance.variant}
    known = [(file, oracle_ids[name]) for name, file in labelled.items() if name in oracle_ids]
    pairs = [(file, truths[name]) for file, name in known if name in truths]
    right = [pair for pair in pairs if _has_right_axes(*pair)]
    right_lines = sum(_has_right_lines(*pair) for pair in right)
    return LabelCounts(len(known), len(pairs), len(right), right_lines, len(truths), len(labelled) - len(known))


def _has_right_axes(labelled: ScanFile, true: ScanFile) -> bool:
    joints = zip(labelled.joints, true.joints, strict=True)
    return all(metrics.is_axis_ok(metrics.axis_error(own.direction, joint.direction)) for own, joint in joints)


def _has_right_lines(labelled: ScanFile, true: ScanFile) -> bool:
    joints = zip(true.joints, labelled.joints, true.extents.centers[1:], strict=True)
    distances = (metrics.line_distance_at_part(*each) for each in joints if each[0].has_pivot)
    return all(map(metrics.is_line_ok, distances))
