"""Pictures of looks: colours of images, vertices and materials where they belong, and what is behind glass."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image as Pillow

from kinmo.core.look import Image, Look, Material
from kinmo.core.shape import Mesh
from kinmo.view.body_colors import RESTING
from kinmo.view.drawn_looks import DrawnLooks
from kinmo.view.picture_raster import Camera
from kinmo.view.studio_picture import AMBIENT, KEY, KEY_LIGHT
from kinmo.view.surface_colors import GAMMA, has_varied_looks

SIZE = 60
CORNERS = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
FACES = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
UVS = (0.5 * CORNERS[:, :2] + 0.5)[FACES]
BRIGHTNESS = AMBIENT - KEY * KEY_LIGHT[2]
"""Brightness of a surface that faces the camera."""
QUARTERS = np.array([[[200, 0, 0], [0, 200, 0]], [[0, 0, 200], [200, 200, 0]]], np.uint8)
"""Red and green above blue and yellow."""


def picture_of(pixels: np.ndarray) -> Image:
    file = io.BytesIO()
    Pillow.fromarray(pixels).save(file, "PNG")
    return Image(file.getvalue(), "image/png", "picture.png")


def square(material: Material | None = None, depth: float = 0.0, **look: np.ndarray) -> Mesh:
    """A square that faces the camera."""
    materials = () if material is None else (material,)
    return Mesh(CORNERS + [0, 0, depth], FACES, Look(materials, np.full(2, len(materials) - 1, np.int32), **look))


def drawn(*meshes: Mesh, notes: list[str] | None = None) -> np.ndarray:
    """RGBA [SIZE, SIZE, 4] of meshes, each of its own body, without the brightness of the light. They look along -z."""
    camera = Camera(np.diag([1.0, -1.0, -1.0]), np.zeros(3), 1.0, 2.0 * SIZE, np.full(2, 0.5 * SIZE), SIZE)
    looks = DrawnLooks(meshes, range(len(meshes)), [].append if notes is None else notes.append)
    image, _ = looks.draw(camera, np.tile(np.eye(4), (len(meshes), 1, 1)), 1, [0] * len(meshes))
    image[..., :3] /= BRIGHTNESS
    return image


def around(image: np.ndarray, x: float, y: float) -> np.ndarray:
    """Colour at a place of the square at depth 0."""
    return image[round(SIZE / 2 - y * SIZE / 3 - 0.5), round(SIZE / 2 + x * SIZE / 3 - 0.5)]


def test_a_textured_square_has_the_colours_of_the_image_at_their_places() -> None:
    texture = picture_of(np.kron(QUARTERS, np.ones((16, 16, 1), np.uint8)))
    image = drawn(square(Material(image=texture), uvs=UVS))
    for (x, y), color in zip(((-0.5, 0.5), (0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)), QUARTERS.reshape(4, 3), strict=True):
        np.testing.assert_allclose(around(image, x, y)[:3], color / 255, atol=0.01)
    assert (image[0, 0] == 0).all()


def test_base_colours_multiply_the_image_as_in_viewers_of_glb() -> None:
    material = Material(base_color=(0.5, 0.2, 1.0, 1.0), image=picture_of(np.full((4, 4, 3), 200, np.uint8)))
    image = drawn(square(material, uvs=UVS))
    np.testing.assert_allclose(around(image, 0.3, 0.1)[:3], 200 / 255 * np.array([0.5, 0.2, 1.0]) ** GAMMA, atol=0.01)


def test_colours_of_vertices_change_evenly_from_corner_to_corner() -> None:
    colors = np.ones((4, 4), np.float32)
    colors[:, 0], colors[:, 1] = [0.1, 0.9, 0.9, 0.1], [0.1, 0.1, 0.7, 0.7]
    image = drawn(square(colors=colors[FACES]))
    for x, y in ((-0.6, -0.6), (0.2, 0.6), (0.6, -0.2)):
        red, green = 0.5 + 0.4 * x, 0.4 + 0.3 * y
        np.testing.assert_allclose(around(image, x, y)[:3], np.array([red, green, 1.0]) ** GAMMA, atol=0.02)


def test_parts_without_a_look_are_grey() -> None:
    np.testing.assert_allclose(around(drawn(Mesh(CORNERS, FACES)), 0.2, 0.1)[:3], RESTING, atol=1e-6)


@pytest.mark.parametrize("is_reversed", [False, True])
def test_glass_shows_what_is_behind_it_in_any_order(is_reversed: bool) -> None:
    wall = square(Material("wall", (0.0, 0.0, 1.0, 1.0)))
    panes = [
        square(Material(name, color, alpha_mode="BLEND"), depth)
        for name, color, depth in (("far", (1.0, 0.0, 0.0, 0.5), 0.2), ("near", (0.0, 1.0, 0.0, 0.25), 0.4))
    ]
    image = drawn(wall, *(reversed(panes) if is_reversed else panes))
    expected = 0.25 * np.array([0, 1, 0]) + 0.75 * (0.5 * np.array([1, 0, 0]) + 0.5 * np.array([0, 0, 1]))
    np.testing.assert_allclose(around(image, 0.1, 0.2), [*expected, 1.0], atol=0.01)


def test_glass_alone_is_translucent_and_hidden_by_what_is_before_it() -> None:
    pane = square(Material("pane", (1.0, 0.0, 0.0, 0.5), alpha_mode="BLEND"), -0.5)
    assert around(drawn(pane), 0.1, 0.1)[3] == pytest.approx(0.5)
    image = drawn(pane, square(Material("wall", (0.0, 0.0, 1.0, 1.0))))
    np.testing.assert_allclose(around(image, 0.1, 0.1), [0, 0, 1, 1], atol=1e-6)


def test_masks_have_holes_and_opaque_materials_have_none() -> None:
    pixels = np.full((32, 32, 4), 200, np.uint8)
    pixels[:, :16, 3], pixels[:, 16:, 3] = 255, 20
    wall = square(Material("wall", (0.0, 0.0, 1.0, 1.0)), -0.5)
    for mode, behind in (("MASK", [0, 0, 1]), ("OPAQUE", [200 / 255] * 3)):
        image = drawn(square(Material(image=picture_of(pixels), alpha_mode=mode), uvs=UVS), wall)
        np.testing.assert_allclose(around(image, -0.5, 0.0)[:3], [200 / 255] * 3, atol=0.01)
        np.testing.assert_allclose(around(image, 0.5, 0.0)[:3], behind, atol=0.01)


def test_a_broken_image_is_one_note_and_its_part_is_drawn() -> None:
    notes: list[str] = []
    material = Material(base_color=(1.0, 0.0, 0.0, 1.0), image=Image(b"nothing", "image/png", "broken.png"))
    image = drawn(square(material, uvs=UVS), square(material, -0.5, uvs=UVS), notes=notes)
    assert len(notes) == 1 and "broken.png" in notes[0]
    np.testing.assert_allclose(around(image, 0.1, 0.2)[:3], [1, 0, 0], atol=1e-6)


RED, BLUE = Material("red", (1.0, 0.0, 0.0, 1.0)), Material("blue", (0.0, 0.0, 1.0, 1.0))
GRADIENT = np.linspace(0.0, 1.0, 24, dtype=np.float32).reshape(2, 3, 4)
PLAIN = Mesh(CORNERS, FACES)


@pytest.mark.parametrize(
    ("meshes", "expected"),
    [
        ((PLAIN, PLAIN), False),
        ((square(RED), square(RED)), False),
        ((square(RED), square(BLUE)), True),
        ((square(RED), PLAIN), True),
        ((square(colors=np.full((2, 3, 4), 0.5, np.float32)),), False),
        ((square(colors=GRADIENT),), True),
        ((square(Material(image=picture_of(QUARTERS)), uvs=UVS),), True),
        ((square(Material(image=picture_of(QUARTERS))),), False),
    ],
)
def test_one_colour_for_all_is_no_varied_look(meshes: tuple[Mesh, ...], expected: bool) -> None:
    assert has_varied_looks(meshes) is expected
