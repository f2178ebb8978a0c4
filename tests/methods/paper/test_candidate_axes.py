"""Candidate axes from the symmetry-aligned box of a part (paper, section 3.3)."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinmo.core.joint import JointKind
from kinmo.core.motion_types import CoarseType, MotionType
from kinmo.core.oriented_box import Box
from kinmo.methods.paper.candidate_axes import candidate_axes

UP = np.array([0.0, 1.0, 0.0])
CONTACT = np.array([0.1, 0.2, 0.3])


def tilted_box(seed: int) -> Box:
    """A random box that is tilted by about 20 degrees."""
    rng = np.random.default_rng(seed)
    axes = Rotation.from_rotvec(rng.normal(size=3) * 0.2).as_matrix()[rng.permutation(3)]
    return Box(rng.normal(size=3), axes, rng.uniform(0.1, 1.0, 3))


@pytest.mark.parametrize(
    ("name", "paper", "release"),
    [
        ("R_H_S", 8, 8 + 2),
        ("R_V_S", 4, 4 + 1),
        ("R_H_C", 2 + 2, 2 + 2),
        ("R_V_C", 1 + 1, 1 + 1),
        ("P_H", 2, 2),
        ("P_V", 1, 1),
        ("PR_H", 2, 2 + 2),
        ("PR_V", 1, 1 + 1),
        ("FIXED", 0, 0),
        ("NONE", 0, 0),
    ],
)
def test_each_type_has_the_papers_number_of_candidates(name: str, paper: int, release: int) -> None:
    box = tilted_box(0)
    assert len(candidate_axes(MotionType[name], box, UP, CONTACT, "central")) == paper
    assert len(candidate_axes(MotionType[name], box, UP, CONTACT, "revolute")) == release


@pytest.mark.parametrize(("name", "count"), [("R", 15), ("P", 3), ("PR", 3), ("FIXED", 0), ("NONE", 0)])
def test_coarse_types_have_all_axes_of_the_box(name: str, count: int) -> None:
    assert len(candidate_axes(CoarseType[name], tilted_box(0), UP, CONTACT)) == count


@pytest.mark.parametrize("seed", range(5))
def test_side_types_have_the_edges_and_vertical_is_the_axis_nearest_to_up(seed: int) -> None:
    box = tilted_box(seed)
    vertical = box.axes[np.argmax(np.abs(box.axes @ UP))]
    for motion, parallel in ((MotionType.R_V_S, True), (MotionType.R_H_S, False)):
        found = candidate_axes(motion, box, UP)
        np.testing.assert_allclose(np.abs(found.directions @ vertical), parallel, atol=1e-12)
        corners = box.corners()
        for direction, pivot in zip(found.directions, found.pivots, strict=True):
            half = box.half_extents[np.argmax(np.abs(box.axes @ direction))]
            for end in (pivot + half * direction, pivot - half * direction):
                assert np.linalg.norm(corners - end, axis=1).min() < 1e-9
        assert len(np.unique(np.round(found.pivots, 9), axis=0)) == len(found)


def test_central_axes_pass_through_the_centre_and_the_interaction_region() -> None:
    box = tilted_box(1)
    found = candidate_axes(MotionType.R_H_C, box, UP, CONTACT)
    np.testing.assert_allclose(found.pivots[:2], np.tile(box.center, (2, 1)))
    np.testing.assert_allclose(found.pivots[2:], np.tile(CONTACT, (2, 1)))
    assert found.sources == ("box centre", "box centre", "interaction region", "interaction region")
    assert all(found.kind(i) is JointKind.REVOLUTE for i in range(4))


def test_without_an_interaction_region_the_centre_remains() -> None:
    assert len(candidate_axes(MotionType.R_V_C, tilted_box(1), UP, None)) == 1
