"""Boxes and joints that follow from point predictions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scanned_objects import cupboard_object, true_global_predictions, true_predictions

from kinmo.config import ScansConfig
from kinmo.scans.poses.point_predictions import MIDDLE, predicted_half_sizes, predicted_joints
from kinmo.scans.rendering.labelled_frames import scan_object

TARGET = cupboard_object()
SCANS = scan_object(TARGET, ScansConfig(states=1, views=1, size=160, points=600, least_pixels=150), 0)
WHOLE = true_global_predictions(TARGET)


def test_boxes_enclose_visible_points_and_are_unknown_for_invisible_parts() -> None:
    predictions = true_predictions(TARGET, SCANS, 0)
    lost = 1
    found = predicted_half_sizes(replace(predictions, parts=np.where(predictions.parts == lost, -1, predictions.parts)))
    assert np.isnan(found[lost]).all()
    visible = np.arange(len(found)) != lost
    assert (found[visible] <= WHOLE.half_sizes[visible] + 1e-6).all()
    npcs, points = predictions.on_part(2)
    assert len(npcs) == len(points) == (predictions.parts == 2).sum()
    assert (np.abs(npcs - MIDDLE) <= found[2]).all()


def test_global_predictions_override_point_predictions() -> None:
    predictions = true_predictions(TARGET, SCANS, 0)
    predictions = replace(predictions, pivots=predictions.pivots + 1.0, npcs=predictions.npcs * 0.5, whole=WHOLE)
    np.testing.assert_array_equal(predicted_half_sizes(predictions), WHOLE.half_sizes)
    directions, pivots = predicted_joints(predictions, TARGET.structure)
    np.testing.assert_array_equal(pivots, WHOLE.pivots)
    for joint, direction, pivot in zip(TARGET.joints, directions, pivots, strict=True):
        np.testing.assert_allclose(np.abs(direction @ joint.direction), 1.0, atol=1e-6)
        if joint.has_pivot:
            np.testing.assert_allclose(np.cross(pivot - 0.5 - joint.pivot, joint.direction), 0.0, atol=1e-6)
