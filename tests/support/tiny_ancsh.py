"""Configurations of ANCSH that train within a second, and batches and frames to test with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinmo.config import AncshConfig, TrainingConfig
from kinmo.scans.ancsh.ancsh_loss import ScanBatch
from kinmo.scans.ancsh.scan_batches import ScanData
from kinmo.scans.files.scan_file import ScanFile
from kinmo.scans.preprocessing.input_frame import base_axes, manhattan_axes

TINY = AncshConfig(
    training=TrainingConfig(epochs=2, learning_rate=3e-3, weight_decay=0.0, decay_epochs=0, threads=1),
    points=128,
    centers=(32, 16),
    neighbours=(8, 8),
    width=0.125,
    dropout=0.0,
    batch_frames=8,
    batches_per_epoch=3,
)
LIKE_RELEASE = replace(TINY, release=True)


def two_scans(file: ScanFile) -> ScanBatch:
    return ScanData([file], [file], TINY).batch([(file, 0), (file, 3)], np.random.default_rng(0))


def frame_with_differing_axes(file: ScanFile) -> int:
    """Frame whose input axes differ most between the first and the second pass."""
    points, parts = file.read("points"), file.read("parts")
    first = manhattan_axes(points)
    second = base_axes(points, parts == 0, first)
    return int(np.abs(second - first).max(axis=(1, 2)).argmax())
