"""Batches of labelled scans, with random frames and points."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterator, Sequence

import numpy as np
import torch
from numpy.typing import NDArray

from kinmo.config import AncshConfig
from kinmo.scans.ancsh.ancsh_loss import ScanBatch
from kinmo.scans.ancsh.ancsh_targets import JointAxes, canonical_coordinates, global_targets, joint_targets
from kinmo.scans.files.scan_file import ScanFile
from kinmo.scans.object_structure import Extents
from kinmo.scans.preprocessing.input_frame import InputFrame

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]

FIRST_PASS_SHARE = 0.5
"""Share of training scans shown along the axes of the first pass, which all networks but the released ones make."""


class ScanData:
    """Batches of frames of many objects, all of one structure.

    In training, every object is drawn with the same probability, whatever the number of its frames or files. Objects with true
    labels together have at least the probability `min_trusted_share`. Validation chooses the best epoch.
    """

    def __init__(self, training: Sequence[ScanFile], validation: Sequence[ScanFile], config: AncshConfig) -> None:
        self.training, self.validation, self.config = list(training), list(validation), config
        trusted = [file.provenance.has_true_labels for file in training]
        objects = [file.object for file in training]
        self._probabilities = file_probabilities(objects, trusted, min_trusted_share(training, config))

    def training_batches(self, epoch: int, rng: np.random.Generator) -> Iterator[ScanBatch]:
        """`batches_per_epoch` batches of random frames."""
        size = self.config.batch_frames
        for _ in range(self.config.batches_per_epoch):
            files = [self.training[i] for i in rng.choice(len(self.training), size=size, p=self._probabilities)]
            yield self.batch([(file, int(rng.integers(file.frames))) for file in files], rng)

    def validation_batches(self) -> Iterator[ScanBatch]:
        """`validation_frames` frames of every object, the same each time."""
        frames = [
            (file, int(row))
            for file in self.validation
            for row in np.unique(np.linspace(0, file.frames - 1, self.config.validation_frames).astype(int))
        ]
        for start in range(0, len(frames), self.config.batch_frames):
            yield self.batch(frames[start : start + self.config.batch_frames], np.random.default_rng(0))

    def batch(self, frames: Sequence[tuple[ScanFile, int]], rng: np.random.Generator) -> ScanBatch:
        """Batch of frames, each given by file and row, with random points; all objects have the same structure."""
        files = [file for file, _ in frames]
        inputs, parts, points = map(np.stack, zip(*(self._sampled(file, row, rng) for file, row in frames), strict=True))
        structure = files[0].structure
        extents, axes = Extents.stack([file.extents for file in files]), JointAxes.of([file.joints for file in files])
        targets = (
            np.where(parts < 0, structure.part_count, parts),
            *canonical_coordinates(points, parts, extents),
            *joint_targets(points, parts, axes, structure, self.config.joint_labels == "release"),
            *global_targets(extents, axes),
            axes.has_pivot,
        )
        return ScanBatch(*map(torch.from_numpy, (inputs, *targets)))

    def _sampled(self, file: ScanFile, row: int, rng: np.random.Generator) -> tuple[NDArray[np.float32], I64, F64]:
        """Random points of a frame: in the input frame [n, 3], their parts [n], and in the normalised frame [n, 3]."""
        rotation = np.eye(3)
        if not self.config.release:
            rotation = file.read("input_axes", row)[0 if rng.random() < FIRST_PASS_SHARE else 1]
        points, parts, places = (file.read(name, row) for name in ("points", "parts", "places"))
        frame = InputFrame.of(points, self.config.normalised, rotation=rotation)  # from all points, as in prediction
        parts = parts.astype(np.int64)
        chosen = sample_points(parts, self.config.points, self.config.balance, rng)
        return frame.apply(points[chosen]), parts[chosen], places[chosen].astype(np.float64)


def min_trusted_share(training: Sequence[ScanFile], config: AncshConfig) -> float:
    """Least probability of scans with true labels.

    It is higher beside scans that networks labelled: these repeat the very errors that training should remove.
    """
    is_self_training = any(file.provenance.role == "unlabelled" for file in training)
    return config.trusted_self_training if is_self_training else config.trusted


def file_probabilities(objects: Sequence[Hashable], trusted: Sequence[bool], min_trusted: float) -> F64:
    """Probabilities [n] that each of n files is drawn, from the object of each file and whether its labels are true.

    All objects have the same probability, except that files with true labels together have `min_trusted` or more.
    """
    is_trusted, files = np.array(trusted, bool), Counter(objects)
    weights = np.array([1.0 / files[one] for one in objects])
    weights /= weights.sum()
    share = weights[is_trusted].sum()
    if 0.0 < share < min_trusted:
        weights = np.where(is_trusted, weights * min_trusted / share, weights * (1.0 - min_trusted) / (1.0 - share))
    return np.asarray(weights)


def sample_points(parts: I64, count: int, balance: float, rng: np.random.Generator) -> I64:
    """Indices [count] of random points of a scan with the `parts` [n], negative for none; they repeat only if there are fewer.

    A `balance` of 0 draws all points with the same probability, 1 as many from every part. Of a part with m points, about
    m ** (1 - balance) are drawn for every one of a part with a single point.
    """
    weights = (np.maximum(np.bincount(parts + 1), 1) ** -balance)[parts + 1]
    if len(parts) < count:
        return rng.choice(len(parts), count, p=weights / weights.sum())
    times = rng.exponential(size=len(parts)) / weights  # the first ones are a weighted draw (Efraimidis and Spirakis 2006)
    return np.argpartition(times, count - 1)[:count]
