"""How right the pseudo labels are that networks for scans learn from, where the true ones were held back."""

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
    """Of objects of one structure whose truth is held back: how many are `labelled` so, how many of these truly `are` so, how
    many of those have all axes `along` the right directions, and how many of those in the `right` places too; how many there
    are to label (`true`); and of how many more that are labelled so the truth is `unknown`.
    """

    labelled: int
    are: int
    along: int
    right: int
    true: int
    unknown: int = 0

    def __str__(self) -> str:
        if not self.labelled and self.unknown:
            return f"Pseudo labels give {counted(self.unknown, 'object')} these joints; what the truth is, is not known."
        found = (
            f"Of {self.labelled} objects that pseudo labels give these joints {self.are} truly have them, {self.along} with "
            f"all axes along the right directions ({math.degrees(MAX_AXIS_ERROR):g} degrees), {self.right} of these with all "
            f"in the right places too ({MAX_LINE_DISTANCE:g} diagonals). In all, {self.true} do."
        )
        return f"{found} Of {self.unknown} more that they give them the truth is not known." if self.unknown else found


def count_labels(said: Sequence[ScanFile], true: Sequence[ScanFile], originals: Mapping[tuple[str, str], str]) -> LabelCounts:
    """Compare the joints of labelled objects with those of their `originals`, which are ids by `ScanFile.object`.

    All files are of one structure, those of variants are passed over. An original that is not among `true` has another one.
    """
    labels = {file.object: file for file in said if not file.provenance.variant}
    truths = {file.id: file for file in true if not file.provenance.variant}
    held_back = [(file, originals[name]) for name, file in labels.items() if name in originals]
    pairs = [(file, truths[original]) for file, original in held_back if original in truths]
    along = [pair for pair in pairs if _is_along(*pair)]
    right = sum(_is_in_place(*pair) for pair in along)
    return LabelCounts(len(held_back), len(pairs), len(along), right, len(truths), len(labels) - len(held_back))


def _is_along(said: ScanFile, true: ScanFile) -> bool:
    joints = zip(said.joints, true.joints, strict=True)
    return all(is_axis_ok(axis_error(mine.direction, joint.direction)) for mine, joint in joints)


def _is_in_place(said: ScanFile, true: ScanFile) -> bool:
    joints = zip(said.joints, true.joints, true.extents.centers[1:], strict=True)
    return all(is_line_ok(line_distance_at_part(joint, mine, middle)) for mine, joint, middle in joints if joint.has_pivot)
