"""Pictures of evaluated scans for the report: predictions beside the truth (as in the paper's figure 5)."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError
from kinmo.evaluation.scan_metrics import FrameScore
from kinmo.io.atomic_files import write_text_atomically
from kinmo.scans.files.scan_file import ScanFile
from kinmo.scans.files.scan_picture import ScanView, scan_picture
from kinmo.scans.object_structure import Structure
from kinmo.scans.poses.scan_estimate import ScanEstimate

HIT_DEGREES, HIT_IOU = 10.0, 0.5
"""Largest rotation error (degrees) and smallest box IoU of any part in a frame that counts as a hit."""
PICTURES = 6  # number of pictures of hits, and of failures
COMMON = 4  # number of frames that the pictures of every run of a category show
DRAWN_POINTS = 512


@dataclass(frozen=True)
class ScanPicture:
    """Picture of one test frame; `text` states its errors. Every run of a category has pictures of the common frames."""

    id: str
    frame: int
    is_hit: bool
    text: str
    svg: str
    is_common: bool = False


@dataclass(frozen=True, eq=False)
class EvaluatedFrame:
    """One test frame with prediction, truth and score."""

    id: str
    frame: int
    points: NDArray[np.floating]
    predicted_parts: NDArray[np.integer]
    true_parts: NDArray[np.integer]
    found: ScanEstimate
    true: ScanEstimate
    score: FrameScore

    @property
    def is_hit(self) -> bool:
        """True if the rotation and the box of every part are right."""
        turned = np.degrees(self.score.rotation)
        return bool((turned <= HIT_DEGREES).all() and (self.score.iou >= HIT_IOU).all())


def view_of(points: NDArray[np.floating], parts: NDArray[np.integer], found: ScanEstimate, structure: Structure) -> ScanView:
    """View of an estimate, or of the truth, to draw."""
    boxes = (found.centers, found.poses.rotations, found.half_extents)
    return ScanView(points, parts, *boxes, structure.kinds, found.directions, found.pivots)


def common_frames(files: Sequence[ScanFile]) -> frozenset[tuple[str, int]]:
    """Middle frames of a few test objects that are evenly spread over all of them, sorted by id."""
    ordered = sorted(files, key=lambda file: file.id)
    places = {len(ordered) * (2 * turn + 1) // (2 * COMMON) for turn in range(COMMON)} if ordered else set()
    return frozenset((ordered[place].id, ordered[place].frames // 2) for place in places)


class PictureBook:
    """Collects a few hits and failures, of as many objects as possible, and all frames in `common` (object id and number)."""

    def __init__(self, structure: Structure, common: frozenset[tuple[str, int]] = frozenset()) -> None:
        self.structure, self.common = structure, common
        self._common: list[EvaluatedFrame] = []
        self._seen = Counter[tuple[bool, str]]()
        self._kept: dict[bool, list[tuple[int, EvaluatedFrame]]] = {True: [], False: []}

    def offer(self, frame: EvaluatedFrame) -> None:
        """Keep a frame if there is room for it."""
        if (frame.id, frame.frame) in self.common:
            self._common.append(frame)
        self._seen[frame.is_hit, frame.id] += 1
        kept = self._kept[frame.is_hit]
        kept.append((self._seen[frame.is_hit, frame.id], frame))
        kept.sort(key=lambda entry: entry[0])
        del kept[PICTURES:]

    def pictures(self) -> list[ScanPicture]:
        """Draw the collected frames: hits, failures, common frames."""
        chosen = [self._draw(frame) for is_hit in (True, False) for _, frame in self._kept[is_hit]]
        return chosen + [replace(self._draw(frame), is_common=True) for frame in self._common]

    def _draw(self, frame: EvaluatedFrame) -> ScanPicture:
        text, points = _errors(frame.score), frame.points[:DRAWN_POINTS]
        sides = ((frame.predicted_parts, frame.found), (frame.true_parts, frame.true))
        views = [view_of(points, parts[:DRAWN_POINTS], estimate, self.structure) for parts, estimate in sides]
        return ScanPicture(frame.id, frame.frame, frame.is_hit, text, scan_picture(views, f"{frame.id}: {text}"))


def _errors(score: FrameScore) -> str:
    def shown(values: NDArray[np.float64], factor: float, unit: str) -> str:
        return " ".join("lost" if math.isnan(value) else f"{factor * value:.0f}{unit}" for value in values)

    turned, axes = (shown(values, math.degrees(1.0), "°") for values in (score.rotation, score.axis))
    return f"parts turned by {turned}, boxes {shown(score.iou, 100.0, '%')}, axes {axes}"


def write_pictures(path: Path, pictures: Iterable[ScanPicture]) -> None:
    """Write one JSON line per picture."""
    write_text_atomically(path, "".join(json.dumps(asdict(picture), ensure_ascii=False) + "\n" for picture in pictures))


def read_pictures(path: Path) -> list[ScanPicture]:
    """Read the pictures that `write_pictures` wrote. Raises InputError for any other file."""
    try:
        return [ScanPicture(**json.loads(line)) for line in path.read_text(encoding="utf-8").splitlines()]
    except (OSError, ValueError, TypeError) as error:
        raise InputError(path, f"expected pictures of kinmo eval ({error})") from None
