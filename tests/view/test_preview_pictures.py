"""Previews: what moves changes the picture, in its colour, and the rest stays."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cabinet_results import cabinet_prediction
from textured_files import factor_alone, vertex_colors

import kinmo
from kinmo.core.errors import InputError
from kinmo.core.shape import Shape
from kinmo.view import preview, preview_pictures
from kinmo.view.body_colors import RESTING
from kinmo.view.object_scene import ObjectScene
from kinmo.view.picture_raster import Camera
from kinmo.view.preview_pictures import Preview, PreviewColors, PreviewStyle
from kinmo.view.scene_building import scene_of
from kinmo.view.surface_raster import Fragments, SurfaceRaster

SIZE = 96
PLAIN = PreviewStyle(SIZE, has_axes=False, has_shadow=False, background=None)


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> ObjectScene:
    return scene_of(cabinet_prediction(tmp_path_factory.mktemp("cabinet")))


def hues(picture: np.ndarray) -> np.ndarray:
    """Colours [N, 3] of opaque pixels, divided by their brightness."""
    colors = picture[picture[..., 3] == 255][:, :3].astype(float)
    return colors / np.maximum(colors.max(axis=1, keepdims=True), 1.0)


def share_like(picture: np.ndarray, color: tuple[float, ...]) -> float:
    """Share of the opaque pixels that have the hue of a colour."""
    return float((np.abs(hues(picture) - np.array(color) / max(color)).max(axis=1) < 0.05).mean())


def test_each_body_is_seen_in_its_colour(scene: ObjectScene) -> None:
    picture = np.asarray(Preview(scene, PLAIN).strip([{}]))
    for body in scene.bodies:
        assert share_like(picture, body.color) > 0.001, body.name


def test_the_first_picture_may_be_grey(scene: ObjectScene) -> None:
    picture = np.asarray(Preview(scene, PLAIN).strip([{}], begins_grey=True))
    half = (picture.shape[1] - round(0.04 * SIZE)) // 2
    assert share_like(picture[:, :half], RESTING) > 0.9
    assert share_like(picture[:, -half:], RESTING) < 0.6


def test_a_joint_value_changes_the_picture(scene: ObjectScene) -> None:
    preview = Preview(scene, PLAIN)
    picture = np.asarray(preview.strip([{}, {3: 0.2}, {}]), int)
    gap = round(0.04 * SIZE)
    width = (picture.shape[1] - 2 * gap) // 3
    rest, opened, again = (picture[:, place * (width + gap) :][:, :width] for place in range(3))
    np.testing.assert_array_equal(rest, again)
    assert 0.02 < (np.abs(opened - rest).sum(axis=-1) > 40).mean() < 0.8


def test_axes_add_their_colour(scene: ObjectScene) -> None:
    plain, drawn = (
        np.asarray(Preview(scene, PreviewStyle(SIZE, has_axes=axes, has_shadow=False, background=None)).strip([{}]))
        for axes in (False, True)
    )
    assert drawn[..., 3].astype(bool).sum() != plain[..., 3].astype(bool).sum()


def test_a_transparent_picture_has_a_shadow_below_alone(scene: ObjectScene) -> None:
    style = PreviewStyle(SIZE, has_axes=False, has_shadow=True, background=None)
    alpha = np.asarray(Preview(scene, style).strip([{}]))[..., 3]
    faint = (alpha > 0) & (alpha < 80)
    assert faint[len(alpha) // 2 :].sum() > 5 * faint[: len(alpha) // 3].sum()


def test_frames_open_and_close_without_empty_margins(scene: ObjectScene) -> None:
    preview = Preview(scene, PreviewStyle(48, samples=1))
    drawn = list(preview.frames(4))
    assert all(frame.size == (48, 48) for frame in drawn)
    assert all(not np.asarray(frame)[[0, -1], :, 3].any() for frame in drawn), "nothing is cut off"
    frames = np.array([np.asarray(frame, int) for frame in preview.trimmed(drawn)])
    assert np.abs(frames[0] - frames[2]).sum() > 0
    seen = (frames != 255).any(axis=(0, 3))
    margins = [np.flatnonzero(seen.any(axis=axis)) for axis in (0, 1)]
    assert all(places[0] < 3 and places[-1] > length - 4 for places, length in zip(margins, seen.shape[::-1], strict=True))


def colors_in(shape: Shape, colors: PreviewColors) -> set[tuple[float, ...]]:
    """Different hues in the picture of a shape."""
    style = PreviewStyle(SIZE, has_axes=False, has_shadow=False, background=None, colors=colors)
    picture = np.asarray(Preview(scene_of(shape), style).strip([{}]))
    return set(map(tuple, np.round(10 * hues(picture)).tolist()))


def test_looks_are_drawn_if_they_tell_parts_apart(tmp_path: Path) -> None:
    many, one = kinmo.load(vertex_colors(tmp_path).path), kinmo.load(factor_alone(tmp_path).path)
    assert colors_in(many, "auto") == colors_in(many, "looks")
    assert len(colors_in(many, "looks")) > 20 > len(colors_in(many, "bodies"))
    assert colors_in(one, "auto") == colors_in(one, "bodies") != colors_in(one, "looks")


def test_large_pictures_have_fewer_samples(scene: ObjectScene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(preview_pictures, "MAX_SAMPLES", 100)
    seen = []
    render = SurfaceRaster.render

    def watched(raster: SurfaceRaster, camera: Camera, poses: np.ndarray, samples: int, *more: Any) -> Fragments:
        seen.append(samples)
        return render(raster, camera, poses, samples, *more)

    monkeypatch.setattr(SurfaceRaster, "render", watched)
    for size in (20, 50, 101):
        Preview(scene, PreviewStyle(size=size, has_axes=False, colors="bodies")).strip([{}])
    assert seen == [3, 2, 1]


def test_unknown_colours_are_an_error(scene: ObjectScene) -> None:
    with pytest.raises(InputError, match="colors: expected one of auto, looks, bodies, found rainbow"):
        preview(scene.shape, colors="rainbow")  # type: ignore[arg-type]
