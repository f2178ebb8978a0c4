"""Labelled frames of scanned objects."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from articulated import shape_of_boxes
from scanned_objects import UP, cupboard_object, slider

from kinmo.config import ScansConfig, SensorConfig
from kinmo.core.mobility import Body
from kinmo.scans.canonical.articulated_object import ArticulatedObject, articulated_object
from kinmo.scans.rendering.labelled_frames import scan_object
from kinmo.scans.rendering.renderers import NO_PART

OPTIONS = ScansConfig(states=4, views=3, size=96, points=300)


@pytest.mark.parametrize(("renderer", "slack"), [("raster", 1e-5), ("pybullet", 1e-4)])
def test_part_poses_map_canonical_positions_to_points(renderer: Literal["raster", "pybullet"], slack: float) -> None:
    target = cupboard_object()
    scans = scan_object(target, replace(OPTIONS, renderer=renderer), seed=0)
    assert len(scans) + scans.skipped.total() == 12
    for row in range(len(scans)):
        poses = scans.poses[row][scans.parts[row]]
        moved = np.einsum("nij,nj->ni", poses[:, :3, :3], scans.places[row]) + poses[:, :3, 3]
        np.testing.assert_allclose(moved, scans.points[row], atol=2e-6)
    for part, mesh in enumerate(target.meshes):
        places = scans.places[scans.parts == part]
        assert (places > mesh.vertices.min(axis=0) - slack).all()
        assert (places < mesh.vertices.max(axis=0) + slack).all()


def test_the_same_seed_gives_the_same_frames() -> None:
    target = cupboard_object()
    one, same, other = (scan_object(target, OPTIONS, seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.points, same.points)
    assert one.points.shape != other.points.shape or not np.array_equal(one.points, other.points)


def test_frames_with_an_invisible_part_are_skipped_and_counted() -> None:
    scans = scan_object(cupboard_object(), replace(OPTIONS, least_pixels=100_000), seed=0)
    assert len(scans) == 0
    assert scans.skipped.total() == 12
    assert all("fewer than 100000 pixels" in reason for reason in scans.skipped)


def test_cameras_surround_the_object_in_its_state_or_at_rest() -> None:
    target = cupboard_object()
    low = np.min([mesh.vertices.min(axis=0) for mesh in target.meshes], axis=0)
    high = np.max([mesh.vertices.max(axis=0) for mesh in target.meshes], axis=0)
    unit = 0.5 * np.linalg.norm(high - low) * np.tan(np.radians(37.5))
    fixed = target.mobility.with_joints(lambda joint: replace(joint, lower=joint.rest, upper=joint.rest))
    closed = replace(target, mobility=fixed)
    options = replace(OPTIONS, states=2, views=40, size=16, least_pixels=0)

    def farthest_camera(scanned: ArticulatedObject, release: bool) -> float:
        poses = scan_object(scanned, replace(options, release=release), seed=5).poses[:, 0]
        eyes = -np.einsum("fji,fj->fi", poses[:, :3, :3], poses[:, :3, 3])
        return float(np.linalg.norm(eyes - 0.5 * (low + high), axis=1).max() / unit)

    limit = 3.3 + 0.4 * np.sqrt(3.0)  # largest distance, and largest offset of the target along all three axes
    assert farthest_camera(target, release=True) < limit < farthest_camera(target, release=False)
    assert farthest_camera(closed, release=False) < limit, "a closed object is at rest"


@pytest.mark.parametrize(
    ("sensor", "moves"),
    [
        (SensorConfig(noise=0.02), True),
        (SensorConfig(holes=0.3), False),
        (SensorConfig(steep=True), False),
        (SensorConfig(crop=0.5), False),
    ],
)
def test_a_noisy_sensor_does_not_change_canonical_positions(sensor: SensorConfig, moves: bool) -> None:
    target = cupboard_object()
    scans = scan_object(target, replace(OPTIONS, sensor=sensor), seed=3)
    assert len(scans)
    poses = np.take_along_axis(scans.poses, scans.parts.astype(np.int64)[..., None, None], axis=1)
    moved = np.einsum("fnij,fnj->fni", poses[..., :3, :3], scans.places) + poses[..., :3, 3]
    off = np.linalg.norm(moved - scans.points, axis=-1)
    assert (off.max() > 1e-3) == moves
    for part, mesh in enumerate(target.meshes):
        places = scans.places[scans.parts == part]
        assert (places < mesh.vertices.max(axis=0) + 1e-5).all()


def test_floor_points_lie_below_the_object_and_have_no_part() -> None:
    target = cupboard_object()
    scans = scan_object(target, replace(OPTIONS, sensor=SensorConfig(floor=True)), seed=4)
    floor = scans.parts == NO_PART
    assert 0.1 < floor.mean() < 0.9
    lowest = min(mesh.vertices[:, 1].min() for mesh in target.meshes)
    for row in range(len(scans)):
        back = np.linalg.inv(scans.poses[row, 0])
        heights = (scans.points[row][floor[row]] @ back[:3, :3].T + back[:3, 3])[:, 1]
        np.testing.assert_allclose(heights, lowest, atol=2e-5)


def test_an_object_may_have_hundreds_of_parts() -> None:
    corners = [(0.1 * row, 0.1 * column) for row in range(20) for column in range(10)]
    keys = [((x, 0.0, z), (x + 0.06, 0.1, z + 0.06)) for x, z in corners]
    board = ((-0.5, -0.1, -0.5), (2.5, 0.0, 1.5))
    pressed = [Body(1 + index, "key", (2 + index,), 0, slider(-UP, upper=0.02)) for index in range(len(keys))]
    shape = shape_of_boxes([board, *keys], [Body(0, "board", (1,)), *pressed])
    target = articulated_object(shape, min_part_size=0.0)
    scans = scan_object(target, replace(OPTIONS, least_pixels=0, size=256, points=2000), seed=0)
    assert scans.parts.min() == 0
    assert scans.parts.max() > 190
