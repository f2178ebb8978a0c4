"""Pictures of scans that evaluation keeps for the report: what was found beside the truth (the paper's figure 5)."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError
from kinmo.evaluation.scan_metrics import FrameScore
from kinmo.io.atomic_files import write_text_atomically
from kinmo.scans.articulated_object import Structure
from kinmo.scans.pose_fitting import ScanEstimate
from kinmo.scans.scan_file import ScanFile
from kinmo.scans.scan_picture import ScanView, scan_picture

HIT_DEGREES, HIT_IOU = 10.0, 0.5
"""A frame is a hit if every part is turned right within so much, and every box overlaps the true one by so much."""
PICTURES = 6
"""Of hits, and as many of failures."""
COMMON = 4
"""Frames that every cell of a category is shown on."""
DRAWN_POINTS = 512


@dataclass(frozen=True)
class ScanPicture:
    """One test frame: `text` says its errors. Of those in `common` every cell of a category has a picture."""

    id: str
    frame: int
    is_hit: bool
    text: str
    svg: str
    is_common: bool = False


@dataclass(frozen=True, eq=False)
class JudgedFrame:
    """All that is needed to draw one test frame."""

    id: str
    frame: int
    points: NDArray[np.floating]
    said_parts: NDArray[np.integer]
    true_parts: NDArray[np.integer]
    found: ScanEstimate
    true: ScanEstimate
    score: FrameScore

    @property
    def is_hit(self) -> bool:
        turned = np.degrees(self.score.rotation)
        return bool((turned <= HIT_DEGREES).all() and (self.score.iou >= HIT_IOU).all())


def view_of(points: NDArray[np.floating], parts: NDArray[np.integer], said: ScanEstimate, structure: Structure) -> ScanView:
    """What is drawn of an estimate, or of the truth."""
    return ScanView(
        points,
        parts,
        said.centers,
        said.poses.rotations,
        said.half_extents,
        structure.kinds,
        said.directions,
        said.pivots,
    )


def common_frames(files: Sequence[ScanFile]) -> frozenset[tuple[str, int]]:
    """Of the test objects some that lie evenly among all, by their ids, and a frame of each: the one in the middle."""
    ordered = sorted(files, key=lambda file: file.id)
    places = {len(ordered) * (2 * turn + 1) // (2 * COMMON) for turn in range(COMMON)} if ordered else set()
    return frozenset((ordered[place].id, ordered[place].frames // 2) for place in places)


class PictureBook:
    """Gathers a few frames, of as many objects as there are: an object's next frame only after every other's first.

    Those in `common` (by object and number) are kept beside them, whatever came of them.
    """

    def __init__(self, structure: Structure, common: frozenset[tuple[str, int]] = frozenset()) -> None:
        self.structure, self.common = structure, common
        self._common: list[JudgedFrame] = []
        self._seen: dict[tuple[bool, str], int] = {}
        self._kept: dict[bool, list[tuple[int, JudgedFrame]]] = {True: [], False: []}

    def offer(self, frame: JudgedFrame) -> None:
        """Keep the frame if it is wanted."""
        if (frame.id, frame.frame) in self.common:
            self._common.append(frame)
        key = (frame.is_hit, frame.id)
        turn = self._seen[key] = self._seen.get(key, 0) + 1
        if turn <= PICTURES:
            kept = self._kept[frame.is_hit]
            kept.append((turn, frame))
            kept.sort(key=lambda entry: entry[0])
            del kept[PICTURES:]

    def pictures(self) -> list[ScanPicture]:
        """Draw what was kept, hits first, those in common last."""
        chosen = [self._draw(frame) for is_hit in (True, False) for _, frame in self._kept[is_hit]]
        return chosen + [replace(self._draw(frame), is_common=True) for frame in self._common]

    def _draw(self, frame: JudgedFrame) -> ScanPicture:
        some = slice(None, DRAWN_POINTS)
        views = [
            view_of(frame.points[some], parts[some], said, self.structure)
            for parts, said in ((frame.said_parts, frame.found), (frame.true_parts, frame.true))
        ]
        text = _errors(frame.score)
        return ScanPicture(frame.id, frame.frame, frame.is_hit, text, scan_picture(views, f"{frame.id}: {text}"))


def _errors(score: FrameScore) -> str:
    def shown(values: NDArray[np.float64], factor: float, unit: str) -> str:
        return " ".join("lost" if math.isnan(value) else f"{factor * value:.0f}{unit}" for value in values)

    turned, overlap = shown(score.rotation, math.degrees(1.0), "°"), shown(score.iou, 100.0, "%")
    return f"parts turned by {turned}, boxes {overlap}, axes {shown(score.axis, math.degrees(1.0), '°')}"


def write_pictures(path: Path, pictures: Iterable[ScanPicture]) -> None:
    """Write one JSON line a picture."""
    write_text_atomically(path, "".join(json.dumps(asdict(picture), ensure_ascii=False) + "\n" for picture in pictures))


def read_pictures(path: Path) -> list[ScanPicture]:
    """The pictures of a file. Raises InputError if it is not what `write_pictures` writes."""
    try:
        lines: list[Mapping[str, object]] = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
        return [ScanPicture(**line) for line in lines]  # type: ignore[arg-type]
    except (OSError, ValueError, TypeError) as error:
        raise InputError(path, f"expected pictures of kinmo eval ({error})") from None
