"""How right the pseudo labels are that networks for scans learn from, where the true ones were held back."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from kinmo.evaluation.metrics import axis_error, line_distance_at_part
from kinmo.evaluation.records import AXIS_WITHIN, LINE_WITHIN
from kinmo.scans.scan_file import ScanFile


@dataclass(frozen=True)
class LabelCounts:
    """Of objects of one structure: how many are `labelled` so, how many of these truly `are` so, and how many of those have all
    joints in the `right` places; and how many there are to label (`true`).
    """

    labelled: int
    are: int
    right: int
    true: int

    def __str__(self) -> str:
        return (
            f"Of {self.labelled} objects that pseudo labels give these joints {self.are} truly have them, {self.right} all in "
            f"the right places ({math.degrees(AXIS_WITHIN):g} degrees, {LINE_WITHIN:g} diagonals). In all, {self.true} do."
        )


def count_labels(said: Sequence[ScanFile], true: Sequence[ScanFile]) -> LabelCounts:
    """Compare the joints of objects by id; all files are of one structure, and those of variants are passed over."""
    labels, truths = ({file.id: file for file in files if not file.is_variant} for files in (said, true))
    known = labels.keys() & truths.keys()
    right = sum(_is_right(labels[name], truths[name]) for name in known)
    return LabelCounts(len(labels), len(known), right, len(truths))


def _is_right(said: ScanFile, true: ScanFile) -> bool:
    for mine, joint, middle in zip(said.joints, true.joints, true.extents.centers[1:], strict=True):
        if axis_error(mine.direction, joint.direction) > AXIS_WITHIN:
            return False
        if joint.has_pivot and line_distance_at_part(joint, mine, middle) > LINE_WITHIN:
            return False
    return True
