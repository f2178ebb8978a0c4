"""Textures: the image's colours at the right places, in any format, near and far."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image as Pillow

from kinmo.core.look import Image
from kinmo.view.texture import Texture

QUARTERS = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 0]]], np.uint8)
"""Red and green above blue and yellow."""
PLACES = np.array([[0.25, 0.75], [0.75, 0.75], [0.25, 0.25], [0.75, 0.25]])
"""Texture coordinates of the middles of the quarters."""


def encoded(pixels: np.ndarray, kind: str = "PNG") -> Image:
    file = io.BytesIO()
    Pillow.fromarray(pixels).save(file, kind)
    return Image(file.getvalue(), f"image/{kind.lower()}")


@pytest.mark.parametrize("turns", [0, 1, -3])
def test_the_lower_left_is_at_zero_and_images_repeat(turns: int) -> None:
    found = Texture(encoded(np.kron(QUARTERS, np.ones((8, 8, 1), np.uint8)))).at(PLACES + turns, np.ones(4))
    np.testing.assert_allclose(255 * found[:, :3], QUARTERS.reshape(4, 3), atol=1e-3)
    assert (found[:, 3] == 1).all()


def test_between_two_texels_are_their_mixtures_also_across_the_border() -> None:
    texture = Texture(encoded(np.array([[[0], [200]]], np.uint8)[..., 0]))
    found = texture.at(np.array([[0.25, 0.5], [0.5, 0.5], [0.75, 0.5], [1.0, 0.5]]), np.ones(4))
    np.testing.assert_allclose(255 * found[:, 0], [0, 100, 200, 100], atol=1e-3)


def test_fine_patterns_from_afar_are_their_mean() -> None:
    board = (255 * (np.indices((64, 64)).sum(axis=0) % 2)).astype(np.uint8)
    places = np.random.default_rng(0).random((500, 2))
    near, far = (Texture(encoded(board)).at(places, np.full(500, spread))[:, 0] for spread in (1.0, 8.0))
    assert near.std() > 0.1
    np.testing.assert_allclose(far, 0.5, atol=0.01)


@pytest.mark.parametrize("mode", ["L", "P", "LA", "RGBA", "I;16", "1"])
def test_images_of_all_modes_have_their_brightness(mode: str) -> None:
    pixels = np.array([[0, 255]], np.uint8).repeat(4, axis=0).repeat(4, axis=1)
    file = io.BytesIO()
    if mode == "I;16":
        Pillow.fromarray(pixels.astype(np.uint16) * 257).save(file, "PNG")
    else:
        Pillow.fromarray(pixels).convert(mode).save(file, "PNG")
    found = Texture(Image(file.getvalue(), "image/png")).at(np.array([[0.25, 0.5], [0.75, 0.5]]), np.ones(2))
    np.testing.assert_allclose(found[:, :3], [[0, 0, 0], [1, 1, 1]], atol=0.005)


def test_opacity_is_that_of_the_image() -> None:
    pixels = np.full((4, 4, 4), 255, np.uint8)
    assert Texture(encoded(pixels)).is_opaque
    pixels[0, 0, 3] = 100
    texture = Texture(encoded(pixels))
    assert not texture.is_opaque
    assert texture.at(np.array([[0.125, 0.875]]), np.ones(1))[0, 3] == pytest.approx(100 / 255)


def test_a_broken_image_is_an_error() -> None:
    whole = encoded(np.random.default_rng(0).integers(0, 255, (64, 64, 3), np.uint8)).data
    for data, problem in ((b"nothing", "its format is unknown"), (whole[: len(whole) // 2], "truncated")):
        with pytest.raises(ValueError, match=problem):
            Texture(Image(data, "image/png"))
