"""Accuracy of the pseudo labels that networks for scans learn from, measured by oracle labels."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from kinmo.core.wording import counted
from kinmo.evaluation.metrics import (
    MAX_AXIS_ERROR,
    MAX_LINE_DISTANCE,
    axis_error,
    is_axis_ok,
    is_line_ok,
    line_distance_at_part,
)
from kinmo.scans.files.scan_file import ScanFile


@dataclass(frozen=True)
class LabelCounts:
    """Numbers of pseudo-labelled objects of one structure.

    Each of the first four is part of the one before.

    Attributes:
        labelled: Objects with this structure by their pseudo labels, and with oracle labels.
        right_structure: Those that truly have this structure.
        right_axes: Those with the right directions of all axes.
        right_lines: Those with all axes in the right places too.
        true: Objects with this structure by their oracle labels, pseudo-labelled or not.
        unknown: Objects with this structure by their pseudo labels, but without oracle labels.
    """

    labelled: int
    right_structure: int
    right_axes: int
    right_lines: int
    true: int
    unknown: int = 0

    def __str__(self) -> str:
        if not self.labelled and self.unknown:
            return f"Pseudo labels give {counted(self.unknown, 'object')} these joints; there are no oracle labels for them."
        text = (
            f"Of {self.labelled} objects that pseudo labels give these joints, {self.right_structure} truly have them, "
            f"{self.right_axes} with the right directions of all axes ({math.degrees(MAX_AXIS_ERROR):g} degrees), "
            f"{self.right_lines} with all axes in the right places too ({MAX_LINE_DISTANCE:g} diagonals). "
            f"In all, {self.true} truly have these joints."
        )
        return f"{text} Another {self.unknown} have no oracle labels." if self.unknown else text


def count_labels(
    pseudo: Sequence[ScanFile], oracle: Sequence[ScanFile], oracle_ids: Mapping[tuple[str, str], str]
) -> LabelCounts:
    """Compare pseudo labels of scanned objects with oracle labels.

    All files have the same structure. Variants of objects do not count. An object whose oracle label is not among `oracle`
    truly has another structure.

    Args:
        pseudo: Scans by pseudo labels.
        oracle: Scans by oracle labels.
        oracle_ids: Id of the shape with the oracle label, by `ScanFile.object` (`ScanDataset.oracle_ids`).
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
    return all(is_axis_ok(axis_error(own.direction, joint.direction)) for own, joint in joints)


def _has_right_lines(labelled: ScanFile, true: ScanFile) -> bool:
    joints = zip(labelled.joints, true.joints, true.extents.centers[1:], strict=True)
    return all(is_line_ok(line_distance_at_part(joint, own, middle)) for own, joint, middle in joints if joint.has_pivot)
