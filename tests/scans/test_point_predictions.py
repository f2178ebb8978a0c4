"""What follows for an object from what is said of points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scanned import cupboard_object, true_answers, true_layout

from kinmo.config import ScansConfig
from kinmo.scans.labelled_frames import scan
from kinmo.scans.point_predictions import MIDDLE, said_half_sizes, said_joints

TARGET = cupboard_object()
SCANS = scan(TARGET, ScansConfig(states=1, views=1, size=160, points=600, least_pixels=150), 0)
LAYOUT = true_layout(TARGET)


def test_boxes_hold_what_is_seen_about_the_middle_and_are_unknown_of_what_is_not() -> None:
    answer = true_answers(TARGET, SCANS, 0)
    lost = 1
    found = said_half_sizes(replace(answer, parts=np.where(answer.parts == lost, -1, answer.parts)))
    assert np.isnan(found[lost]).all()
    seen = np.arange(len(found)) != lost
    assert (found[seen] <= LAYOUT.half_sizes[seen] + 1e-6).all()
    npcs, points = answer.on_part(2)
    assert len(npcs) == len(points) == (answer.parts == 2).sum()
    assert (np.abs(npcs - MIDDLE) <= found[2]).all()


def test_what_is_said_of_the_whole_counts_before_what_points_say() -> None:
    answer = true_answers(TARGET, SCANS, 0)
    answer = replace(answer, pivots=answer.pivots + 1.0, npcs=answer.npcs * 0.5, layout=LAYOUT)
    np.testing.assert_array_equal(said_half_sizes(answer), LAYOUT.half_sizes)
    directions, pivots = said_joints(answer, TARGET.structure)
    np.testing.assert_array_equal(pivots, LAYOUT.pivots)
    for joint, direction, pivot in zip(TARGET.joints, directions, pivots, strict=True):
        np.testing.assert_allclose(np.abs(direction @ joint.direction), 1.0, atol=1e-6)
        if joint.has_pivot:
            np.testing.assert_allclose(np.cross(pivot - 0.5 - joint.pivot, joint.direction), 0.0, atol=1e-6)
