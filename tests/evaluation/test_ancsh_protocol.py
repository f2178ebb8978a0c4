"""The figures of ANCSH's public evaluation code, faults included."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinmo import _core
from kinmo.config import ScansConfig
from kinmo.evaluation.ancsh_protocol import box_overlap, score_as_ancsh
from kinmo.evaluation.scan_metrics import score_frame
from kinmo.scans.scan import scan
from scanned import cupboard_object, true_estimate

CONFIG = ScansConfig(states=1, views=3, size=96, points=256, least_pixels=1, smallest_part=0.05)


def corners(sizes, shift=(0.0, 0.0, 0.0)):
    signs = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3, indexing="ij"), axis=-1)
    return np.array(shift) + 0.5 * signs * np.array(sizes)


@pytest.mark.parametrize(
    ("sizes", "shift", "printed", "exact"),
    [((0.1, 0.7, 0.7), (0.05, 0.0, 0.0), 1.000, 0.333), ((0.6, 0.5, 0.6), (0.1, 0.0, 0.0), 0.975, 0.714)],
)
def test_overlaps_are_as_wrong_as_measured(sizes, shift, printed, exact):
    assert box_overlap(corners(sizes), corners(sizes, shift)) == pytest.approx(printed, abs=0.03)
    boxes = [(np.array([center]), np.eye(3)[None], 0.5 * np.array([sizes])) for center in (np.zeros(3), np.array(shift))]
    assert _core.box_iou(*boxes[0], *boxes[1])[0] == pytest.approx(exact, abs=0.001)


@pytest.fixture(scope="module")
def seen():
    target = cupboard_object()
    scans = scan(target, CONFIG, seed=1)
    return target, [true_estimate(target, scans, row) for row in range(len(scans))]


def test_the_truth_has_no_error_by_either(seen):
    target, truths = seen
    for true in truths:
        score = score_as_ancsh(true, true, target.structure)
        assert score is not None
        for name in ("rotation", "translation", "state", "axis", "line"):
            np.testing.assert_allclose(getattr(score, name), 0.0, atol=1e-6, err_msg=name)
        np.testing.assert_allclose(score.iou, 1.0)


def test_rotations_and_corners_are_those_of_the_default_measures(seen):
    target, truths = seen
    for found, true in zip(truths, truths[1:] + truths[:1], strict=True):
        coded, exact = score_as_ancsh(found, true, target.structure), score_frame(found, true, target.structure)
        assert coded is not None
        np.testing.assert_allclose(coded.rotation, exact.rotation, atol=1e-6)
        np.testing.assert_allclose(coded.translation, exact.corner, atol=1e-9)


def test_a_frame_with_anything_missing_is_dropped(seen):
    target, truths = seen
    lost = replace(truths[0], states=np.full_like(truths[0].states, np.nan))
    assert score_as_ancsh(lost, truths[0], target.structure) is None
