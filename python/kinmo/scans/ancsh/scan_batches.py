"""Batches of labelled scans."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterator, Sequence

import numpy as np
import torch
from numpy.typing import NDArray

from kinmo.config import AncshConfig
from kinmo.scans.ancsh.ancsh_loss import ScanBatch
from kinmo.scans.ancsh.ancsh_targets import JointAxes, canonical_coordinates, layout, surroundings
from kinmo.scans.files.scan_file import ScanFile
from kinmo.scans.object_structure import Extents
from kinmo.scans.preprocessing.input_frame import InputFrame

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]

FIRST_LOOKS = 0.5
"""The share of scans that are seen as at first sight, where networks look twice."""


class ScanData:
    """Frames of many objects, mixed anew every epoch; objects have equal odds whatever the number of their frames, or files.

    Of all that are drawn those with true labels have the share `least_trusted` at least, where there are others.
    """

    def __init__(self, training: Sequence[ScanFile], validation: Sequence[ScanFile], config: AncshConfig) -> None:
        self.training, self.validation, self.config = list(training), list(validation), config
        trusted = [file.provenance.has_true_labels for file in training]
        self._odds = odds([file.object for file in training], trusted, least_trusted(training, config))

    def training_batches(self, epoch: int, rng: np.random.Generator) -> Iterator[ScanBatch]:
        size = self.config.batch_frames
        for _ in range(self.config.batches_per_epoch):
            files = [self.training[i] for i in rng.choice(len(self.training), size=size, p=self._odds)]
            yield self.batch([(file, int(rng.integers(file.frames))) for file in files], rng)

    def validation_batches(self) -> Iterator[ScanBatch]:
        frames = [
            (file, int(row))
            for file in self.validation
            for row in np.unique(np.linspace(0, file.frames - 1, self.config.validation_frames).astype(int))
        ]
        for start in range(0, len(frames), self.config.batch_frames):
            yield self.batch(frames[start : start + self.config.batch_frames], np.random.default_rng(0))

    def batch(self, frames: Sequence[tuple[ScanFile, int]], rng: np.random.Generator) -> ScanBatch:
        """Frames, each given as a row of a file; of objects of one structure."""
        files = [file for file, _ in frames]
        points, parts, places = map(np.stack, zip(*(self._drawn(file, row, rng) for file, row in frames), strict=True))
        structure, labels = files[0].structure, self.config.joint_labels
        extents, axes = Extents.stack([file.extents for file in files]), JointAxes.of([file.joints for file in files])
        near = surroundings(places, parts, axes, structure, nearest=labels == "nearest", lines_only=labels == "release")
        said = (
            np.where(parts < 0, structure.part_count, parts),
            *canonical_coordinates(places, parts, extents),
            *(near.joints, near.heatmap, near.toward, near.axes, near.has_pivot),
            *layout(extents, axes),
            axes.has_pivot,
        )
        return ScanBatch(*map(torch.from_numpy, (points, *said)))

    def _drawn(self, file: ScanFile, row: int, rng: np.random.Generator) -> tuple[F32, NDArray[np.int64], F64]:
        """Of points that are drawn from a frame: what a network sees of them [n, 3], their parts [n], their places [n, 3]."""
        rotation = self._rotation(file, row, rng)
        points, parts, places = (file.read(name, row) for name in ("points", "parts", "places"))
        frame = InputFrame.of(points, self.config.normalised, rotation=rotation)  # of all, as of a scan that is asked about
        parts = parts.astype(np.int64)
        chosen = drawn(parts, self.config.points, self.config.balance, rng)
        return frame.apply(points[chosen]), parts[chosen], places[chosen].astype(np.float64)

    def _rotation(self, file: ScanFile, row: int, rng: np.random.Generator) -> F64:
        """The axes [3, 3] that a frame is seen along."""
        if self.config.axes == "camera":
            return np.eye(3)
        is_first = self.config.axes != "base" or rng.random() < FIRST_LOOKS
        look: F64 = file.read("input_axes", row)[0 if is_first else 1]
        return look


def least_trusted(training: Sequence[ScanFile], config: AncshConfig) -> float:
    """The least share of scans with true labels, which is another beside those that networks labelled: these repeat the errors
    of what they are to learn beyond.
    """
    is_semi = any(file.provenance.role == "unlabelled" for file in training)
    return config.trusted_in_semi if is_semi else config.trusted


def odds(objects: Sequence[Hashable], trusted: Sequence[bool], least: float) -> F64:
    """How likely each of n files, of some `objects`, is to be drawn, [n]: all objects equally, but those of `trusted` files
    together `least` likely.
    """
    is_trusted, files = np.array(trusted, bool), Counter(objects)
    weights = np.array([1.0 / files[one] for one in objects])
    weights /= weights.sum()
    share = weights[is_trusted].sum()
    if 0.0 < share < least:
        weights = np.where(is_trusted, weights * least / share, weights * (1.0 - least) / (1.0 - share))
    return np.asarray(weights)


def drawn(parts: NDArray[np.int64], count: int, balance: float, rng: np.random.Generator) -> NDArray[np.int64]:
    """Indices [count] of points of `parts` [n] (below 0: of none), each but once where there are as many.

    Of m points of a part about m ** (1 - `balance`) are drawn for every one of a part with a single point: 0 draws all points
    with equal odds, 1 as many of every part.
    """
    weights = (np.maximum(np.bincount(parts + 1), 1) ** -balance)[parts + 1]
    if len(parts) < count:
        return rng.choice(len(parts), count, p=weights / weights.sum())
    times = rng.exponential(size=len(parts)) / weights  # which of them come first is a draw by weights (Efraimidis 2006)
    return np.argpartition(times, count - 1)[:count]
