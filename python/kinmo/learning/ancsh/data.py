"""Batches of labelled scans."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import torch
from numpy.typing import NDArray

from kinmo.config import AncshConfig
from kinmo.learning.ancsh.loss import ScanBatch
from kinmo.learning.ancsh.targets import canonical_coordinates, surroundings
from kinmo.scans.input_frame import InputFrame
from kinmo.scans.scan_file import ScanFile


class ScanData:
    """Frames of many objects, mixed anew every epoch; objects have equal odds whatever the number of their frames."""

    def __init__(self, training: Sequence[ScanFile], validation: Sequence[ScanFile], config: AncshConfig) -> None:
        self.training, self.validation, self.config = list(training), list(validation), config

    def training_batches(self, epoch: int, rng: np.random.Generator) -> Iterator[ScanBatch]:
        size = self.config.batch_frames
        for _ in range(self.config.batches_per_epoch):
            files = [self.training[i] for i in rng.integers(len(self.training), size=size)]
            yield collate([(file, int(rng.integers(file.frames))) for file in files], self.config, rng)

    def validation_batches(self) -> Iterator[ScanBatch]:
        frames = [
            (file, int(row))
            for file in self.validation
            for row in np.unique(np.linspace(0, file.frames - 1, self.config.validation_frames).astype(int))
        ]
        for start in range(0, len(frames), self.config.batch_frames):
            yield collate(frames[start : start + self.config.batch_frames], self.config, np.random.default_rng(0))


def collate(frames: Sequence[tuple[ScanFile, int]], config: AncshConfig, rng: np.random.Generator) -> ScanBatch:
    """A batch of frames, each given as a row of a file."""
    columns: list[tuple[NDArray[np.generic], ...]] = [_targets(file, row, config, rng) for file, row in frames]
    return ScanBatch(*(torch.from_numpy(np.stack(column)) for column in zip(*columns, strict=True)))


def _targets(file: ScanFile, row: int, config: AncshConfig, rng: np.random.Generator) -> tuple[NDArray[np.generic], ...]:
    points, parts, places = (file.read(name, row) for name in ("points", "parts", "places"))
    chosen = rng.choice(len(points), config.points, replace=len(points) < config.points)
    points, parts, places = points[chosen], parts[chosen].astype(np.int64), places[chosen].astype(np.float64)
    npcs, naocs = canonical_coordinates(places, parts, file.extents)
    near = surroundings(
        places,
        parts,
        file.joints,
        file.structure,
        nearest=config.joint_labels == "nearest",
        lines_only=config.joint_labels == "release",
    )
    classes = np.where(parts < 0, file.structure.part_count, parts)
    seen = InputFrame.of(points, config.normalised).apply(points)
    return seen, classes, npcs, naocs, near.joints, near.heatmap, near.toward, near.axes, near.has_pivot
