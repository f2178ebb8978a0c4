"""The page without a server: one file, nothing fetched, and its sliders move what they name."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import trimesh
from browser import READY, OpenPage, needs_driven_browser, open_page
from cabinet_results import cabinet_prediction
from PIL import Image

import kinmo
from kinmo.view.object_scene import ObjectScene
from kinmo.view.scene_building import scene_of
from kinmo.view.scene_data import scene_json
from kinmo.view.static_page import static_page, write_static_page

WIDTHS = [1280, 390]


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> ObjectScene:
    return scene_of(cabinet_prediction(tmp_path_factory.mktemp("cabinet")))


@pytest.fixture(scope="module", params=WIDTHS)
def shown(request: pytest.FixtureRequest, scene: ObjectScene, tmp_path_factory: pytest.TempPathFactory) -> Iterator[OpenPage]:
    path = write_static_page([scene], tmp_path_factory.mktemp("page") / "page.html")
    with open_page(path.as_uri(), request.param) as opened:
        opened.page.wait_for_selector(READY)
        yield opened


def move(shown: OpenPage, name: str, end: str) -> None:
    slider = shown.page.get_by_label(name, exact=True)
    slider.scroll_into_view_if_needed()
    slider.focus()
    shown.page.keyboard.press(end)


def test_a_page_names_no_other_file(scene: ObjectScene) -> None:
    html = static_page([scene])
    for word in ("http://", "https://", '<link rel="stylesheet', "src=", "import("):
        assert word not in html


def test_objects_that_do_not_fit_are_named(scene: ObjectScene) -> None:
    html = static_page([scene, scene, scene], most=len(scene_json(scene)) + 1)
    assert html.count('type="application/json"') == 1
    assert "Left out, as the page would be too large: 2 objects (cabinet, cabinet)." in html
    assert "Left out" not in static_page([scene, scene])


@needs_driven_browser
def test_a_slider_moves_its_part_and_back(shown: OpenPage) -> None:
    shown.page.evaluate("document.activeElement.blur(); window.scrollTo(0, 0)")
    canvas = shown.page.locator("canvas")

    def picture() -> np.ndarray:
        shown.page.evaluate("document.activeElement.blur(); window.scrollTo(0, 0)")
        shown.page.mouse.move(1, 1)
        whole, box = shown.settled_picture(), canvas.bounding_box()
        return whole[int(box["y"]) : int(box["y"] + box["height"]), int(box["x"]) : int(box["x"] + box["width"])]

    rest = picture()
    move(shown, "door: hinge", "End")
    opened = picture()
    changed = np.abs(opened - rest).sum(axis=-1) > 30
    assert 0.01 < changed.mean() < 0.6
    blue = (rest[..., 2] > rest[..., 0] + 40) & (rest[..., 2] > 100)  # the door is the first body that moves
    assert changed[blue].mean() > 0.5
    assert shown.page.get_by_label("door: hinge", exact=True).get_attribute("aria-valuetext") == "90°"
    move(shown, "door: hinge", "Home")
    np.testing.assert_array_equal(picture(), rest)


@needs_driven_browser
def test_the_page_fits_and_every_slider_can_be_reached(shown: OpenPage) -> None:
    assert not shown.scrolls_sideways()
    sliders = shown.page.locator("input[type=range]")
    assert sliders.count() == 3
    for place in range(3):
        sliders.nth(place).scroll_into_view_if_needed()
        box = sliders.nth(place).bounding_box()
        assert box["x"] >= 0 and box["x"] + box["width"] <= shown.page.viewport_size["width"] and box["width"] > 90
        assert sliders.nth(place).get_attribute("aria-label")


@needs_driven_browser
def test_another_joint_can_be_tried_and_kept(shown: OpenPage) -> None:
    choice = shown.page.get_by_label("Joint of door", exact=True)
    choice.select_option(label="3. slider, to the front 0.20")
    assert shown.page.get_by_label("door: slider", exact=True).is_enabled()
    assert '[bodies."door"]\nalternative = 3' in shown.page.inner_text(".kv-fix")
    choice.select_option(label="4. fixed 0.10")
    assert shown.page.get_by_label("door: fixed", exact=True).is_disabled()
    choice.select_option(label="1. hinge, vertical, right edge 0.40")
    assert not shown.page.locator(".kv-fix").is_visible()


@needs_driven_browser
def test_improbable_joints_are_marked(shown: OpenPage) -> None:
    badges = [each.inner_text() for each in shown.page.locator(".kv-badge").all()]
    assert badges == ["40 % uncertain", "60 %", "90 %"]


@needs_driven_browser
def test_playing_moves_the_slider_until_it_is_stopped(shown: OpenPage) -> None:
    button, slider = shown.page.get_by_label("Play front", exact=True), shown.page.get_by_label("front: slider", exact=True)
    button.click()
    shown.page.wait_for_function("e => Number(e.value) > 0.05", arg=slider.element_handle())
    button.click()
    value = slider.input_value()
    shown.page.wait_for_timeout(300)
    assert slider.input_value() == value
    shown.page.get_by_text("Reset", exact=True).click()
    assert float(slider.input_value()) == 0.0


@needs_driven_browser
def test_dragging_and_the_wheel_change_the_view(shown: OpenPage) -> None:
    shown.page.evaluate("window.scrollTo(0, 0)")
    before = shown.settled_picture()
    box = shown.page.locator("canvas").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    shown.page.mouse.move(x, y)
    shown.page.mouse.down()
    shown.page.mouse.move(x + 60, y + 20)
    shown.page.mouse.up()
    turned = shown.settled_picture()
    shown.page.mouse.wheel(0, -300)
    assert not np.array_equal(before, turned) and not np.array_equal(turned, shown.settled_picture())


@needs_driven_browser
def test_the_console_is_silent_and_nothing_is_fetched(shown: OpenPage) -> None:
    assert not shown.complaints
    assert all(url.startswith(("file:", "data:", "blob:")) for url in shown.requests)


@needs_driven_browser
def test_textures_and_colours_of_the_file_can_be_shown(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    for place, look in enumerate((Image.new("RGB", (8, 8), (0, 200, 0)), [0.0, 0.0, 0.2122, 1.0])):
        box = trimesh.creation.box((1, 1, 1), trimesh.transformations.translation_matrix((1.2 * place, 0, 0)))
        given = {"baseColorTexture": look} if place == 0 else {"baseColorFactor": look}
        material = trimesh.visual.material.PBRMaterial(**given, metallicFactor=0.0)
        box.visual = trimesh.visual.TextureVisuals(uv=np.full((len(box.vertices), 2), 0.5), material=material)
        scene.add_geometry(box, node_name=f"box_{place}")
    scene.export(tmp_path / "boxes.glb")
    page = write_static_page([scene_of(kinmo.load(tmp_path / "boxes.glb"))], tmp_path / "page.html")
    with open_page(page.as_uri()) as opened:
        opened.page.wait_for_selector(READY)
        opened.page.get_by_label("Textures", exact=True).check()
        picture = opened.settled_picture()[:, :800]
        green, blue = ((picture[..., k] > 60) & (picture.sum(axis=-1) == picture[..., k]) for k in (1, 2))
        assert green.sum() > 5000 and blue.sum() > 5000
        brightest = picture[blue][:, 2].max()
        assert 110 < brightest < 145, "a linear 0.2122 is half of the brightness of a screen"
        assert not opened.complaints


@needs_driven_browser
def test_a_menu_chooses_among_objects(scene: ObjectScene, tmp_path: Path) -> None:
    path = write_static_page([scene, scene_of(scene.shape)], tmp_path / "page.html")
    with open_page(path.as_uri()) as opened:
        opened.page.wait_for_selector(READY)
        opened.page.get_by_label("Object", exact=True).select_option(index=1)
        opened.page.wait_for_selector("text=No joints.")
        opened.page.wait_for_selector(READY)
        assert not opened.complaints
