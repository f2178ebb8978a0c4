"""The commands view and render-preview as a user starts them."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
import urllib.request
from pathlib import Path

import numpy as np
import pytest
from cabinet_results import result_in
from PIL import Image
from textured_files import obj_with_mtl
from typer.testing import CliRunner

from kinmo.cli.app import app
from kinmo.io.readers.overrides_reader import OVERRIDES_FILE
from kinmo.view import object_views


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return result_in(tmp_path_factory.mktemp("result"))


def run(*arguments: str) -> tuple[int, str, str]:
    done = CliRunner().invoke(app, list(arguments))
    return done.exit_code, done.stdout, done.stderr


def test_a_page_is_written_with_the_corrections_beside_the_result(result: Path, tmp_path: Path) -> None:
    code, out, _ = run("view", str(result), "--html", str(tmp_path / "new" / "page.html"))
    assert code == 0 and out.splitlines()[-1] == str(tmp_path / "new" / "page.html")
    html = (tmp_path / "new" / "page.html").read_text(encoding="utf-8")
    assert "hinge, vertical, left edge, by hand" in html and '"drawer"' in html


@pytest.mark.parametrize("what", ["cabinet.urdf", "joints.json", ""])
def test_results_robots_and_folders_can_be_shown(what: str, result: Path, tmp_path: Path) -> None:
    path = result / what if what else result.parent
    code, out, _ = run("view", str(path), "--html", str(tmp_path / "page.html"), "--quiet")
    assert (code, out) == (0, f"{tmp_path / 'page.html'}\n")


def test_results_of_one_shape_are_told_apart(result: Path, tmp_path: Path) -> None:
    for place in ("a", "deep/b"):
        shutil.copytree(result, tmp_path / "results" / place)
    code, out, _ = run("view", str(tmp_path / "results"), "--html", str(tmp_path / "page.html"), "--json")
    assert code == 0 and json.loads(out)["objects"] == ["a", "deep/b"]


def test_a_broken_file_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "robot.urdf").write_text("<robot", encoding="utf-8")
    for command in (["view", "--no-browser"], ["view", "--html", str(tmp_path / "page.html")], ["render-preview"]):
        code, _, error = run(command[0], str(tmp_path / "robot.urdf"), *command[1:])
        assert code == 1 and error.count("\n") == 1 and "robot.urdf" in error
    assert run("view", str(tmp_path / "missing.glb"), "--no-browser")[0] == 1


def test_repairs_of_a_file_are_shown(tmp_path: Path) -> None:
    box = '<visual><geometry><box size="1 1 1"/></geometry></visual>'
    lost = '<visual><geometry><mesh filename="lost.obj"/></geometry></visual>'
    (tmp_path / "cube.urdf").write_text(f'<robot name="r"><link name="a">{box}{lost}</link></robot>', encoding="utf-8")
    page, picture = tmp_path / "page.html", tmp_path / "picture.png"
    for command in (["view", "--html", str(page)], ["render-preview", "-o", str(picture), "--size", "16", "--poses", "1"]):
        code, _, error = run(command[0], str(tmp_path / "cube.urdf"), *command[1:])
        assert code == 0 and "repaired: cube: lost.obj skipped: " in error


def test_without_viser_the_remedies_are_named(result: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(object_views, "find_spec", lambda name: None)
    code, _, error = run("view", str(result))
    assert code == 1 and error.count("\n") == 1
    assert "pip install 'kinmo[view]'" in error and "--html" in error


def test_a_wrong_correction_is_named(result: Path, tmp_path: Path) -> None:
    copy = result_in(tmp_path, "[bodies.nonsense]\nflip = true\n")
    code, _, error = run("view", str(copy), "--html", str(tmp_path / "page.html"))
    assert code == 1 and OVERRIDES_FILE in error and "nonsense" in error


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_server_ends_cleanly(number: signal.Signals, result: Path) -> None:
    pytest.importorskip("viser", reason="viser is not installed")
    command = [
        sys.executable,
        "-c",
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # the parent may ignore it
        "from kinmo.cli import main; main()",
        "view",
        str(result),
        "--no-browser",
        "--port",
        "18300",
    ]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ})
    assert process.stderr is not None
    line = process.stderr.readline()
    assert line.startswith("http://127.0.0.1:18300"), line
    with urllib.request.urlopen(line.split()[0], timeout=120) as page:
        assert b"<html" in page.read()
    time.sleep(0.2)
    process.send_signal(number)
    out, error = process.communicate(timeout=120)
    assert process.returncode == 0 and error == "" and out == f"{result}\n"


def test_a_preview_has_the_size_and_a_gif_moves(result: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from kinmo.view import preview_files

    monkeypatch.setattr(preview_files, "FRAMES", 4)
    code, out, _ = run(
        "render-preview", str(result), "-o", str(tmp_path / "a.png"), "--size", "64", "--transparent", "--before"
    )
    picture = Image.open(tmp_path / "a.png")
    assert (code, out) == (0, f"{tmp_path / 'a.png'}\n") and picture.mode == "RGBA" and picture.height <= 64
    assert run("render-preview", str(result), "-o", str(tmp_path / "a.gif"), "--size", "64")[0] == 0
    assert Image.open(tmp_path / "a.gif").n_frames == 4


def test_a_preview_has_the_looks_of_the_file_or_colours_of_bodies(tmp_path: Path) -> None:
    path = obj_with_mtl(tmp_path).path
    options = ("--size", "48", "--poses", "1")
    for name, more in (("looks", ()), ("bodies", ("--colors", "bodies"))):
        assert run("render-preview", str(path), "-o", str(tmp_path / f"{name}.png"), *options, *more)[0] == 0
    looks, bodies = (np.asarray(Image.open(tmp_path / f"{name}.png"), int) for name in ("looks", "bodies"))
    assert np.abs(looks - bodies).max() > 100
    code, _, error = run("render-preview", str(path), "--colors", "rainbow")
    assert code == 2 and "rainbow" in error


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["-o", "a.jpg"], "ends in .png"),
        (["-o", "a.gif", "--transparent"], "--transparent"),
        (["-o", "a.gif", "--before"], "--before"),
    ],
)
def test_wrong_options_are_one_line(arguments: list[str], problem: str, result: Path) -> None:
    code, _, error = run("render-preview", str(result), *arguments)
    assert code == 1 and problem in error and error.count("\n") == 1
