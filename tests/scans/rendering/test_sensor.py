"""Faults of depth sensors."""

from __future__ import annotations

import numpy as np
import pytest

from kinmo.config import SensorConfig
from kinmo.scans.rendering.pinhole_camera import Camera
from kinmo.scans.rendering.renderers import NO_PART, DepthImages
from kinmo.scans.rendering.sensor import MIN_FACING_COSINE, apply_sensor

CAMERA = Camera.from_field_of_view(120, 120, 40.0, 0.1, 10.0)


def wall(cosine: float, frames: int = 20) -> DepthImages:
    """Images of a wall through z = 2, by the cosine between its normal and the camera's axis."""
    normal = np.array([np.sqrt(1.0 - cosine**2), 0.0, cosine])
    depths = 2.0 * cosine / (CAMERA.rays() @ normal)
    depths = np.where((depths > CAMERA.near) & (depths < CAMERA.far), depths, 0.0).astype(np.float32)
    parts = np.where(depths > 0.0, 0, NO_PART).astype(np.int32)
    return DepthImages(np.stack([depths] * frames), np.stack([parts] * frames))


def sensed(images: DepthImages, sensor: SensorConfig, floor: float = 1.0) -> DepthImages:
    """Images of a sensor on a level camera at the height `floor` above the floor."""
    floors = np.tile([0.0, -1.0, 0.0, -floor], (len(images.depths), 1))
    return apply_sensor(images, sensor, CAMERA, floors, np.random.default_rng(0))


def kept(images: DepthImages) -> np.ndarray:
    """Share of the pixels of each image that have a depth."""
    np.testing.assert_array_equal(images.depths > 0.0, images.parts != NO_PART)
    return (images.parts != NO_PART).mean(axis=(1, 2))


def test_holes_cover_their_share_in_patches() -> None:
    found = sensed(wall(1.0), SensorConfig(holes=0.3))
    np.testing.assert_allclose(kept(found), 0.7, atol=0.001)
    lost = found.parts == NO_PART
    alike = (lost[:, 1:] == lost[:, :-1]).mean()
    assert alike > 0.9, "pixel by pixel it would be .58"


def test_a_crop_removes_up_to_its_share_on_one_side_of_a_line() -> None:
    found = sensed(wall(1.0), SensorConfig(crop=0.5))
    shares = kept(found)
    assert (shares > 0.49).all()
    assert shares.min() < 0.6
    rows, columns = np.indices(found.parts.shape[1:])
    for part in found.parts:
        lost = part == NO_PART
        middles = [np.array([rows[some].mean(), columns[some].mean()]) for some in (lost, ~lost)]
        along = (rows * (middles[0] - middles[1])[0] + columns * (middles[0] - middles[1])[1])[..., None]
        assert np.median(along[lost]) > np.quantile(along[~lost], 0.9)


@pytest.mark.parametrize(("cosine", "is_lost"), [(1.0, False), (0.6, False), (0.5 * MIN_FACING_COSINE, True)])
def test_only_steep_surfaces_are_lost(cosine: float, is_lost: bool) -> None:
    images = wall(cosine)
    middle = (slice(None), slice(50, 70), slice(58, 62))  # where the ray is nearly the camera's axis
    assert (images.parts[middle] != NO_PART).all()
    found = sensed(images, SensorConfig(steep=True))
    assert ((found.parts[middle] == NO_PART) == is_lost).all()


def test_the_ideal_sensor_changes_nothing() -> None:
    images = wall(0.8)
    assert sensed(images, SensorConfig()) is images


def test_noise_has_its_deviation_and_is_correlated() -> None:
    images = wall(1.0)
    noise = (sensed(images, SensorConfig(noise=0.01)).depths - images.depths) / images.depths**2
    assert noise.std() == pytest.approx(0.01, rel=0.03)
    assert np.corrcoef(noise[:, :, 1:].ravel(), noise[:, :, :-1].ravel())[0, 1] > 0.8


def test_faults_do_not_depend_on_the_position_in_the_image() -> None:
    depths, parts = np.zeros((1, 120, 120), np.float32), np.full((1, 120, 120), NO_PART, np.int32)
    depths[0, 10:50, 20:70], parts[0, 10:50, 20:70] = 2.0, 0
    far = DepthImages(np.roll(depths, (60, 40), (1, 2)), np.roll(parts, (60, 40), (1, 2)))
    sensor = SensorConfig(noise=0.01, holes=0.2, crop=0.3)
    here, there = sensed(DepthImages(depths, parts), sensor), sensed(far, sensor)
    np.testing.assert_array_equal(np.roll(here.parts, (60, 40), (1, 2)), there.parts)
    np.testing.assert_array_equal(np.roll(here.depths, (60, 40), (1, 2)), there.depths)


@pytest.mark.parametrize("floor", [0.3, -0.3])
def test_a_floor_is_visible_from_above_only(floor: float) -> None:
    depths, parts = np.zeros((1, 120, 120), np.float32), np.full((1, 120, 120), NO_PART, np.int32)
    depths[0, 40:80, 40:80], parts[0, 40:80, 40:80] = 2.0, 0
    found = sensed(DepthImages(depths, parts), SensorConfig(floor=True), floor)
    np.testing.assert_array_equal(found.parts, parts)
    is_floor = (found.depths > 0.0) & (parts == NO_PART)
    assert is_floor.any() == (floor > 0.0)
    assert not is_floor[0, :60].any(), "none above the horizon"


def test_an_empty_image_stays_empty() -> None:
    nothing = DepthImages(np.zeros((2, 120, 120), np.float32), np.full((2, 120, 120), NO_PART, np.int32))
    found = sensed(nothing, SensorConfig(noise=0.01, holes=0.2, crop=0.3, steep=True))
    assert not found.depths.any()
    assert (found.parts == NO_PART).all()
