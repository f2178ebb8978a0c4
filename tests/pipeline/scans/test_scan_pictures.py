"""Pictures of evaluated frames: the choice of frames, and the text below them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scanned_objects import cupboard_object, true_estimate

from kinmo.config import ScansConfig
from kinmo.core.errors import InputError
from kinmo.evaluation.scan_metrics import FrameScore, score_frame
from kinmo.pipeline.scans.scan_pictures import (
    PICTURES,
    EvaluatedFrame,
    PictureBook,
    common_frames,
    read_pictures,
    write_pictures,
)
from kinmo.scans.rendering.labelled_frames import scan_object

TARGET = cupboard_object()
SEEN = scan_object(TARGET, ScansConfig(states=1, views=1, size=64, points=64), 3)
TRUE = true_estimate(TARGET, SEEN, 0)
RIGHT = score_frame(TRUE, TRUE, TARGET.structure)
WRONG = replace(RIGHT, rotation=RIGHT.rotation + np.radians(20.0))


def frame(name: str, number: int, score: FrameScore) -> EvaluatedFrame:
    return EvaluatedFrame(name, number, SEEN.points[0], SEEN.parts[0], SEEN.parts[0], TRUE, TRUE, score)


def book_of(frames: list[EvaluatedFrame], common: frozenset[tuple[str, int]] = frozenset()) -> PictureBook:
    book = PictureBook(TARGET.structure, common)
    for each in frames:
        book.offer(each)
    return book


@pytest.mark.parametrize(
    ("score", "is_hit"),
    [
        (RIGHT, True),
        (WRONG, False),
        (replace(RIGHT, rotation=np.where(np.arange(len(RIGHT.rotation)) == 1, np.nan, RIGHT.rotation)), False),
        (replace(RIGHT, iou=0.4 * RIGHT.iou), False),
    ],
    ids=["all right", "turned", "one part not found", "boxes too large"],
)
def test_a_hit_has_every_part_and_box_in_place(score: FrameScore, is_hit: bool) -> None:
    assert frame("a", 0, score).is_hit is is_hit


def test_hits_come_first_and_every_object_is_shown_once_before_any_twice() -> None:
    frames = [frame("a", number, score) for number in range(8) for score in (RIGHT, WRONG)]
    frames += [frame(name, 0, RIGHT) for name in "bcd"]
    pictures = book_of(frames).pictures()
    assert [picture.is_hit for picture in pictures] == [True] * PICTURES + [False] * PICTURES
    shown = [(picture.id, picture.frame) for picture in pictures if picture.is_hit]
    assert shown == [("a", 0), ("b", 0), ("c", 0), ("d", 0), ("a", 1), ("a", 2)]


def test_common_frames_are_always_shown() -> None:
    frames = [frame("a", number, RIGHT) for number in range(2 * PICTURES)]
    pictures = book_of(frames, frozenset({("a", 2 * PICTURES - 1), ("b", 0)})).pictures()
    assert [(picture.frame, picture.is_common) for picture in pictures[PICTURES - 1 :]] == [(5, False), (11, True)]


def test_pictures_come_back_from_their_file_with_their_errors_in_words(tmp_path: Path) -> None:
    lost = replace(RIGHT, rotation=np.full_like(RIGHT.rotation, np.nan))
    pictures = book_of([frame("a", 0, WRONG), frame("b", 0, lost)]).pictures()
    write_pictures(tmp_path / "pictures.jsonl", pictures)
    assert read_pictures(tmp_path / "pictures.jsonl") == pictures
    assert "parts turned by 20° 20°" in pictures[0].text
    assert "parts turned by lost lost" in pictures[1].text
    assert all(picture.svg.startswith("<svg") and picture.id in picture.svg for picture in pictures)
    (tmp_path / "pictures.jsonl").write_text('{"id": "a"}\n', encoding="utf-8")
    with pytest.raises(InputError, match="expected pictures of kinmo eval"):
        read_pictures(tmp_path / "pictures.jsonl")


def test_common_frames_are_the_middle_ones_of_evenly_spread_objects() -> None:
    files = [SimpleNamespace(id=name, frames=5) for name in "hgfedcba"]
    assert common_frames(files) == {(name, 2) for name in "bdfh"}
    assert common_frames(files[-1:]) == {("a", 2)}
    assert common_frames([]) == frozenset()
