"""The page of viser: its sliders move parts, and its controls write overrides.toml."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from threading import Thread

import numpy as np
import pytest
from browser import OpenPage, needs_driven_browser, open_page
from cabinet_results import cabinet_prediction, result_in

import kinmo
from kinmo.core.errors import InputError
from kinmo.io.readers.overrides_reader import OVERRIDES_FILE, read_overrides

pytest.importorskip("viser", reason="viser is not installed")
from kinmo.view.viser_server import ObjectServer

DOOR, KNOB, FRONT = 1, 2, 3
NAMES = ("door", "knob", "front")
PORT = 18234


@pytest.fixture
def result(tmp_path: Path) -> Path:
    return result_in(tmp_path, None)


@pytest.fixture
def server(result: Path) -> Iterator[ObjectServer]:
    made = ObjectServer(kinmo.Prediction.load(result), result, port=PORT)
    yield made
    made.stop()


def row(server: ObjectServer, index: int):  # type: ignore[no-untyped-def]
    return server.panels.rows[index]


def test_nodes_are_where_the_prediction_has_the_links(server: ObjectServer) -> None:
    row(server, DOOR).move(0.5)
    row(server, FRONT).move(0.1)
    poses = server.scene.poses({DOOR: 0.5, FRONT: 0.1})
    scale, offset = server.placement
    for index, nodes in enumerate(server.nodes):
        for node in nodes:
            real = abs(float(node.wxyz[0]))
            assert 2.0 * math.acos(min(1.0, real)) == pytest.approx(0.5 if index in (DOOR, KNOB) else 0.0, abs=1e-6)
            np.testing.assert_allclose(node.position, scale * poses[index, :3, 3] + offset, atol=1e-9)


def test_another_joint_changes_slider_title_and_file(server: ObjectServer, result: Path) -> None:
    controls = row(server, DOOR)
    assert controls.folder.label == "door: hinge, 40%, uncertain"
    controls.choice.value = controls.choice.options[2]
    controls.chosen()
    assert controls.folder.label == "door: slider, by hand"
    assert controls.slider.max == pytest.approx(0.2) and "slide" in controls.slider.label
    assert not (result / OVERRIDES_FILE).exists()
    server.panels.attempt(server.panels.save)
    assert read_overrides(result / OVERRIDES_FILE).table == {"bodies": {"door": {"alternative": 3}}}


def test_name_type_and_range_are_corrected_together(server: ObjectServer, result: Path) -> None:
    controls = row(server, FRONT)
    controls.name.value, controls.range.value = "drawer", (0.0, 0.35)
    server.panels.correct(controls.apply)
    assert controls.slider.max == pytest.approx(0.35) and controls.folder.label.startswith("drawer: slider")
    server.panels.attempt(server.panels.save)
    assert read_overrides(result / OVERRIDES_FILE).table == {"bodies": {"front": {"range": [0.0, 0.35], "name": "drawer"}}}


@pytest.mark.parametrize("upper", [0.012345, 0.345678])
def test_a_new_name_leaves_the_range(upper: float, server: ObjectServer) -> None:
    assert server.corrections is not None
    server.panels.correct(lambda: server.corrections.set_range("front", 0.0, upper))
    controls = row(server, FRONT)
    assert controls.range.value == pytest.approx((0.0, upper), rel=1e-3)
    controls.name.value = "drawer"
    server.panels.correct(controls.apply)
    assert server.corrections.table == {"bodies": {"front": {"range": [0.0, upper], "name": "drawer"}}}


def test_a_range_is_taken_with_a_new_type(server: ObjectServer) -> None:
    controls = row(server, DOOR)
    controls.type.value, controls.range.value = "slider", (0.0, 0.07)
    server.panels.correct(controls.apply)
    assert server.corrections is not None
    assert server.corrections.table == {"bodies": {"door": {"type": "slider", "range": [0.0, 0.07]}}}


def test_a_wrong_range_takes_back_the_new_type_too(server: ObjectServer) -> None:
    controls = row(server, DOOR)
    controls.type.value, controls.range.value = "slider", (0.05, 0.07)
    server.panels.correct(controls.apply)
    assert server.corrections is not None and server.corrections.table == {}
    assert "Not possible" in server.panels.status.content
    assert controls.type.value == "hinge" and controls.folder.label == "door: hinge, 40%, uncertain"


def test_corrections_at_the_same_time_are_all_kept(server: ObjectServer, monkeypatch: pytest.MonkeyPatch) -> None:
    corrections = server.corrections
    assert corrections is not None
    change = type(corrections)._change

    def slow(*arguments: object) -> None:
        before = dict(corrections.table)
        time.sleep(0.1)
        assert corrections.table == before
        change(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(type(corrections), "_change", slow)
    people = [Thread(target=server.panels.correct, args=[partial(corrections.set_name, name, f"new_{name}")]) for name in NAMES]
    for person in people:
        person.start()
    for person in people:
        person.join()
    assert corrections.table == {"bodies": {name: {"name": f"new_{name}"} for name in NAMES}}


def test_hidden_axes_stay_hidden_after_a_correction(server: ObjectServer) -> None:
    server.set_axes(False)
    server.panels.correct(row(server, DOOR).reset)
    assert not any(arrow.visible for arrow in server._arrows if arrow is not None)


def test_words_of_a_file_are_no_markup(result: Path) -> None:
    prediction = kinmo.Prediction.load(result)
    shape = replace(prediction.shape, category="<img src=x>")
    made = ObjectServer(replace(prediction, shape=shape), port=PORT + 2)
    try:
        assert "\\<img src=x\\>" in made.panels.facts.content
    finally:
        made.stop()


def test_a_wrong_range_is_told_and_taken_back(server: ObjectServer) -> None:
    controls = row(server, FRONT)
    controls.range.value = (0.1, 0.2)
    server.panels.correct(controls.apply)
    assert "Not possible" in server.panels.status.content and "contains 0" in server.panels.status.content
    assert controls.range.value == pytest.approx((0.0, 0.2))


def test_a_body_can_be_fixed_and_released(server: ObjectServer) -> None:
    controls = row(server, DOOR)
    controls.move(0.3)
    controls.type.value = "fixed"
    server.panels.correct(controls.apply)
    assert controls.slider.disabled and DOOR not in server.values
    server.panels.correct(controls.reset)
    assert not controls.slider.disabled and controls.folder.label == "door: hinge, 40%, uncertain"


def test_a_shape_of_its_own_joints_has_no_corrections(tmp_path: Path) -> None:
    prediction = cabinet_prediction(tmp_path)
    prediction.export(tmp_path / "robot", ["urdf"], collision="none")
    made = ObjectServer(kinmo.load(tmp_path / "robot" / "robot.urdf"), port=PORT + 1)
    try:
        assert made.corrections is None and len(made.panels.rows) == 3
    finally:
        made.stop()


def test_without_viser_the_message_names_the_remedy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(InputError, match=r"pip install 'kinmo\[view\]'"):
        ObjectServer(cabinet_prediction(tmp_path))


def settled(shown: OpenPage) -> np.ndarray:
    """The 3D view without the panel and the notifications."""
    shown.page.wait_for_timeout(800)
    picture = shown.settled_picture()
    width = picture.shape[1]
    return picture[200:330, : width - 330] if width > 800 else picture[150:330]


@needs_driven_browser
@pytest.mark.parametrize(("width", "height"), [(1280, 480), (390, 844)])
def test_a_slider_moves_its_part_and_back_in_a_browser(width: int, height: int, server: ObjectServer) -> None:
    with open_page(server.url, width, height) as shown:
        shown.page.wait_for_selector("text=door: hinge", timeout=60_000)
        shown.page.wait_for_selector("canvas")
        shown.page.wait_for_timeout(2000)
        slider = shown.page.get_by_role("slider").first
        slider.evaluate("e => e.scrollIntoView()")
        box = slider.bounding_box()
        assert box["x"] >= 0 and box["x"] + box["width"] <= width
        assert not shown.scrolls_sideways()
        slider.focus()
        rest = settled(shown)
        slider.press("End")
        opened = settled(shown)
        assert server.values[DOOR] == pytest.approx(math.pi / 2)
        assert (np.abs(opened - rest).sum(axis=-1) > 40).mean() > 0.01
        slider.press("Home")
        assert (np.abs(settled(shown) - rest).sum(axis=-1) > 40).mean() < 0.001
        assert not shown.complaints
        assert all(url.startswith((server.url, "data:", "blob:")) for url in shown.requests)
