"""Labels that networks give to scans."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scanned_objects import cupboard, true_predictions

from kinmo.config import ScansConfig
from kinmo.experiments.self_training.self_labels import UNSURE, self_labelled
from kinmo.scans.ancsh.ancsh_targets import canonical_coordinates
from kinmo.scans.canonical.articulated_object import articulated_object
from kinmo.scans.object_structure import Extents
from kinmo.scans.poses.pose_fitting import PoseOptions, estimate_poses
from kinmo.scans.rendering.labelled_frames import scan_object

CONFIG = ScansConfig(states=2, views=4, size=160, points=2048, least_pixels=4, smallest_part=0.05)
NAME = ("one", "Cupboard")


@pytest.fixture(scope="module", params=[CONFIG.smallest_part, 0.0], ids=["", "with a part on a moving one"])
def seen(request):
    target = articulated_object(cupboard(), min_part_size=request.param)
    assert any(target.structure.parents) is (request.param == 0.0)
    scans = scan_object(target, CONFIG, seed=3)
    answers = [true_predictions(target, scans, row) for row in range(len(scans))]
    return target, scans, answers, estimate_poses(answers, target.structure, PoseOptions(hypotheses=500))


def test_what_networks_say_without_error_is_the_true_label(seen):
    target, scans, answers, found = seen
    made = self_labelled(NAME, scans.points, answers, found, target.structure, 0.8)
    assert made is not None
    said, labelled = made
    assert len(labelled) == len(scans)
    assert (labelled.parts == scans.parts).all()
    true = canonical_coordinates(scans.places, scans.parts.astype(int), Extents.stack([target.part_extents]))
    own = canonical_coordinates(labelled.places, labelled.parts.astype(int), Extents.stack([said.part_extents]))
    for mine, right in zip(own, true, strict=True):
        np.testing.assert_allclose(mine, right, atol=2e-3)
    for mine, right in zip(said.joints, target.joints, strict=True):
        assert mine.kind is right.kind
        np.testing.assert_allclose(mine.direction, right.direction, atol=1e-3)


def test_frames_that_say_opposite_directions_still_tell_the_line(seen):
    target, scans, answers, found = seen
    split = [replace(one, directions=-one.directions) if row % 2 else one for row, one in enumerate(found)]
    made = self_labelled(NAME, scans.points, answers, split, target.structure, 0.0)
    assert made is not None
    for mine, right in zip(made[0].joints, target.joints, strict=True):
        assert abs(mine.direction @ right.direction) > 0.999


def test_frames_that_networks_are_not_sure_of_are_left_out(seen):
    target, scans, answers, found = seen
    doubtful = [replace(one, inliers=np.full_like(one.inliers, 0.5)) if row % 2 else one for row, one in enumerate(found)]
    made = self_labelled(NAME, scans.points, answers, doubtful, target.structure, 0.8)
    assert made is not None
    assert len(made[1]) == len(scans) - len(scans) // 2
    assert made[1].skipped == {UNSURE: len(scans) // 2}
    assert self_labelled(NAME, scans.points, answers, doubtful, target.structure, 1.1) is None
