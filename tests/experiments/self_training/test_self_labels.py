"""Labels that supervised networks give to scans."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scanned_objects import cupboard, true_predictions

from kinmo.config import ScansConfig
from kinmo.experiments.self_training.self_labels import UNSURE, self_label
from kinmo.scans.ancsh.ancsh_targets import canonical_coordinates
from kinmo.scans.canonical.articulated_object import articulated_object
from kinmo.scans.object_structure import Extents
from kinmo.scans.poses.pose_fitting import PoseOptions, estimate_poses
from kinmo.scans.rendering.labelled_frames import scan_object

CONFIG = ScansConfig(states=2, views=4, size=160, points=2048, least_pixels=4, smallest_part=0.05)


@pytest.fixture(scope="module", params=[CONFIG.smallest_part, 0.0], ids=["", "with a part on a moving one"])
def seen(request):
    target = articulated_object(cupboard(), min_part_size=request.param)
    assert any(target.structure.parents) is (request.param == 0.0)
    scans = scan_object(target, CONFIG, seed=3)
    predictions = [true_predictions(target, scans, row) for row in range(len(scans))]
    return target, scans, predictions, estimate_poses(predictions, target.structure, PoseOptions(hypotheses=500))


def labelled(target, scans, predictions, found, confidence):
    return self_label("one", "Cupboard", scans.points, predictions, found, structure=target.structure, confidence=confidence)


def test_perfect_predictions_give_the_true_labels(seen):
    target, scans, predictions, found = seen
    made = labelled(target, scans, predictions, found, 0.8)
    assert made is not None
    predicted, frames = made
    assert len(frames) == len(scans)
    assert (frames.parts == scans.parts).all()
    true = canonical_coordinates(scans.places, scans.parts.astype(int), Extents.stack([target.part_extents]))
    own = canonical_coordinates(frames.places, frames.parts.astype(int), Extents.stack([predicted.part_extents]))
    for mine, right in zip(own, true, strict=True):
        np.testing.assert_allclose(mine, right, atol=2e-3)
    for mine, right in zip(predicted.joints, target.joints, strict=True):
        assert mine.kind is right.kind
        np.testing.assert_allclose(mine.direction, right.direction, atol=1e-3)


def test_frames_with_opposite_directions_still_give_the_line(seen):
    target, scans, predictions, found = seen
    split = [replace(own, directions=-own.directions) if row % 2 else own for row, own in enumerate(found)]
    made = labelled(target, scans, predictions, split, 0.0)
    assert made is not None
    for mine, right in zip(made[0].joints, target.joints, strict=True):
        assert abs(mine.direction @ right.direction) > 0.999


def test_frames_that_the_networks_are_not_sure_of_are_skipped(seen):
    target, scans, predictions, found = seen
    doubtful = [replace(own, inliers=np.full_like(own.inliers, 0.5)) if row % 2 else own for row, own in enumerate(found)]
    made = labelled(target, scans, predictions, doubtful, 0.8)
    assert made is not None
    assert len(made[1]) == len(scans) - len(scans) // 2
    assert made[1].skipped == {UNSURE: len(scans) // 2}
    assert labelled(target, scans, predictions, doubtful, 1.1) is None
