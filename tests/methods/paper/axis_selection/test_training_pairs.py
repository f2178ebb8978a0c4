"""Training pairs of the axis selection network: clouds, negative axes, and batches (paper, section 3.3)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from small_shapes import box_surface, cabinet

from kinmo.config import load_config
from kinmo.core.joint import Joint, JointKind
from kinmo.core.oriented_box import Box
from kinmo.methods.paper.axis_selection.training_pairs import (
    PairData,
    joint_samples,
    motion_difference,
    negative_axes,
    random_axis_permutation,
)
from kinmo.methods.paper.axis_selection.transformed_clouds import MIN_SHARE, labelled_cloud

CONFIG = load_config("small").axis
UP = np.array([0.0, 1.0, 0.0])


def points_of_box(half: tuple[float, float, float], count: int = 600) -> np.ndarray:
    """Points on the surface of a centred box."""
    return box_surface(np.zeros(3), np.array(half), count, np.random.default_rng(0))[0].astype(np.float32)


def cylinder(count: int = 600, radius: float = 0.2) -> np.ndarray:
    """Points on the side of an upright cylinder."""
    rng = np.random.default_rng(0)
    angle, height = rng.uniform(0, 2 * np.pi, count), rng.uniform(-0.1, 0.1, count)
    return np.column_stack([radius * np.cos(angle), height, radius * np.sin(angle)]).astype(np.float32)


def hinge(direction, pivot) -> Joint:
    return Joint(JointKind.REVOLUTE, np.array(direction, float), np.array(pivot, float), 0.0, 1.5)


def test_no_edge_of_the_hinge_side_is_a_negative_of_a_door() -> None:
    half = (0.3, 0.4, 0.01)
    box = Box(np.zeros(3), np.eye(3), np.array(half))
    found = negative_axes(hinge(UP, (0.3, 0, 0.01)), box, points_of_box(half), CONFIG)
    assert len(found) == 10  # 12 edges without the two at the hinge
    at_hinge = (np.abs(found.directions @ UP) > 0.99) & (found.pivots[:, 0] > 0.29)
    assert not at_hinge.any()
    other_side = (np.abs(found.directions @ UP) > 0.99) & (found.pivots[:, 0] < -0.29)
    assert other_side.sum() == 2


def test_an_axis_with_the_same_motion_of_a_round_part_is_no_negative() -> None:
    part = cylinder()
    off_center = np.array([[0.0, 0.0, 0.0], [0.2, 0.0, 0.0]])
    difference = motion_difference(hinge(UP, (0, 0, 0)), np.tile(UP, (2, 1)), off_center, part)
    assert difference[0] < 0.01 < difference[1]
    # Turns about a cylinder's axis do not change the cylinder, turns about a tilted axis do.
    tilted = motion_difference(hinge(UP, (0, 0, 0)), np.array([[1.0, 0.0, 0.0]]), np.zeros((1, 3)), part)
    assert tilted[0] > 0.02


def test_the_negatives_of_a_slider_are_the_other_two_axes() -> None:
    half = (0.3, 0.2, 0.25)
    box = Box(np.zeros(3), np.eye(3), np.array(half))
    joint = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3), 0.0, 0.3)
    found = negative_axes(joint, box, points_of_box(half), CONFIG)
    assert len(found) == 2
    np.testing.assert_allclose(found.directions @ joint.direction, 0)


def test_small_parts_have_negatives() -> None:
    half = (0.01, 0.012, 0.006)
    box = Box(np.zeros(3), np.eye(3), np.array(half))
    joint = hinge((0, 0, 1), (0, 0, 0))
    assert len(negative_axes(joint, box, points_of_box(half), CONFIG)) >= 8


@pytest.mark.parametrize("seed", range(3))
def test_a_cloud_has_enough_points_of_part_and_rest(seed: int) -> None:
    shape = cabinet(seed)
    for moving in ([0], list(range(len(shape.leaves) - 1)), list(range(len(shape.leaves)))):
        cloud = labelled_cloud(shape.leaf_points, shape.leaf_areas, moving, 200, np.random.default_rng(seed))
        assert cloud.points.shape == (200, 3)
        own = {tuple(p) for p in shape.leaf_points[moving].reshape(-1, 3).tolist()}
        assert all(tuple(p) in own for p in cloud.points[: cloud.moving].tolist())
        assert not any(tuple(p) in own for p in cloud.points[cloud.moving :].tolist())
        if len(moving) < len(shape.leaves):
            assert MIN_SHARE - 0.01 <= cloud.moving / 200 <= 1 - MIN_SHARE + 0.01


def test_a_focused_cloud_is_denser_near_the_part_and_centred_on_it() -> None:
    shape = cabinet(1)
    plain, focused = (
        labelled_cloud(shape.leaf_points, shape.leaf_areas, [2], 400, np.random.default_rng(0), focus=focus)
        for focus in (False, True)
    )
    gaps = [np.linalg.norm(cloud.points[cloud.moving :] - focused.center, axis=1).mean() for cloud in (plain, focused)]
    assert gaps[1] < 0.8 * gaps[0]
    part = focused.network_input()[: focused.moving, :3]
    np.testing.assert_allclose(part.max(axis=0) + part.min(axis=0), 0, atol=1e-5)
    assert np.linalg.norm(part, axis=1).max() <= 1 + 1e-5
    np.testing.assert_array_equal(plain.network_input()[:, :3], plain.points)


def test_a_focused_cloud_does_not_depend_on_size_and_position() -> None:
    shape = cabinet(1)
    points = (3.0 * shape.leaf_points + np.array([1.0, 2.0, 3.0])).astype(np.float32)
    clouds = [
        labelled_cloud(leaves, shape.leaf_areas, [0], 200, np.random.default_rng(0), focus=True).network_input()
        for leaves in (shape.leaf_points, points)
    ]
    np.testing.assert_allclose(*clouds, atol=1e-4)


def test_only_labelled_points_move() -> None:
    shape = cabinet(1)
    cloud = labelled_cloud(shape.leaf_points, shape.leaf_areas, [2], 100, np.random.default_rng(0))
    moved = cloud.transformed(np.array([1], np.uint8), UP[None], np.zeros((1, 3)), np.zeros((1, 2)), np.array([[0.0, 0.5]]))
    np.testing.assert_allclose(moved[0, 0], cloud.points, atol=1e-6)
    np.testing.assert_allclose(moved[0, 1, : cloud.moving], cloud.points[: cloud.moving] + 0.5 * UP, atol=1e-6)
    np.testing.assert_array_equal(moved[0, 1, cloud.moving :], cloud.points[cloud.moving :])


def test_batches_depend_on_the_generator_alone_and_label_the_moving_part() -> None:
    samples = joint_samples([cabinet(seed) for seed in range(4)], CONFIG)
    data = PairData(samples, samples, CONFIG)
    one, other = ([*data.training_batches(0, np.random.default_rng(5))] for _ in range(2))
    assert all(torch.equal(a.feasible, b.feasible) for a, b in zip(one, other, strict=True))
    batch = one[0]
    for cloud in (batch.original, batch.feasible, batch.infeasible):
        assert cloud.shape[1:] == (CONFIG.encoder.points, 4)
        assert torch.equal(cloud[..., 3], batch.original[..., 3])
    still = batch.original[..., 3] == 0
    assert torch.equal(batch.original[still], batch.feasible[still])
    assert not torch.allclose(batch.feasible[~still], batch.infeasible[~still])


@pytest.mark.parametrize(("balance", "expected"), [(0.0, [1, 1, 1, 1, 1]), (0.5, [2, 1, 1, 1, 1]), (1.0, [4, 1, 1, 1, 1])])
def test_joints_with_rare_names_are_drawn_more_often(balance: float, expected: list[float]) -> None:
    sample = joint_samples([cabinet(1)], CONFIG)[0]
    samples = [replace(sample, name=name) for name in ("lid", "door", "door", "door", "door")]
    weights = PairData(samples, samples, replace(CONFIG, name_balance=balance)).weights
    np.testing.assert_allclose(weights, np.array(expected) / sum(expected))


@pytest.mark.parametrize("seed", range(5))
def test_an_axis_permutation_keeps_the_label(seed: int) -> None:
    turn = random_axis_permutation(np.random.default_rng(seed))
    np.testing.assert_array_equal(turn @ turn.T, np.eye(4))
    np.testing.assert_array_equal(np.abs(turn).sum(axis=0), 1)
    np.testing.assert_array_equal(turn[3], [0, 0, 0, 1])
