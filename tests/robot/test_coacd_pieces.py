"""Convex pieces by CoACD in processes of their own."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
import trimesh

from kinmo.core.shape import Mesh
from kinmo.robot import coacd_pieces
from kinmo.robot.coacd_pieces import CACHE_FOLDER, divided

pytest.importorskip("coacd")

TORUS = trimesh.creation.torus(1.0, 0.2, major_sections=16, minor_sections=8)
RING = Mesh(np.asarray(TORUS.vertices, float), np.asarray(TORUS.faces, np.uint32))


@pytest.fixture(autouse=True)
def cache(monkeypatch, tmp_path):
    """An empty cache folder."""
    monkeypatch.setenv(CACHE_FOLDER, str(tmp_path / "cache"))
    return tmp_path / "cache" / "coacd"


def replace_coacd(monkeypatch, folder, division, first="") -> None:
    """Let the processes import a module coacd whose run_coacd has one statement. `first` runs when it is imported."""
    folder.mkdir(exist_ok=True)
    lines = ["import os, signal", "import numpy as np", first, "Mesh = set_log_level = lambda *arrays: arrays"]
    lines += ["def run_coacd(mesh, **settings):", f"    {division}"]
    (folder / "coacd.py").write_text("\n".join(lines))
    monkeypatch.setenv("PYTHONPATH", str(folder))


def test_pieces_together_have_about_the_volume() -> None:
    (pieces,) = divided([RING])
    volume = sum(trimesh.convex.convex_hull(points).volume for points in pieces)
    assert volume == pytest.approx(TORUS.volume, rel=0.35)


def test_pieces_are_remembered(monkeypatch, cache) -> None:
    first = divided([RING, RING])
    assert len(list(cache.iterdir())) == 1
    monkeypatch.setattr(coacd_pieces, "_run_all", lambda *_: pytest.fail("ran again"))
    again = divided([RING])
    assert [points.tolist() for points in again[0]] == [points.tolist() for points in first[0]]


def test_a_damaged_memory_is_made_anew(cache) -> None:
    (first,) = divided([RING])
    (file,) = cache.iterdir()
    file.write_bytes(b"damaged")
    (again,) = divided([RING])
    assert len(again) == len(first)


def test_a_surface_that_ends_the_process_has_no_pieces_and_stops_no_other(monkeypatch, tmp_path) -> None:
    script = tmp_path / "dies_on_seven_faces.py"
    script.write_text(
        "import os, sys\nimport numpy as np\n"
        "for number in sys.argv[4:]:\n"
        "    name = os.path.join(sys.argv[1], number)\n"
        "    surface = np.load(name + '.npz')\n"
        "    open(name + '.started', 'w').close()\n"
        "    if len(surface['faces']) == 7:\n"
        "        os.abort()\n"
        "    np.savez(name + '.pieces.npz', points=surface['vertices'], counts=[len(surface['vertices'])])\n"
    )
    monkeypatch.setattr(coacd_pieces.coacd_process, "__file__", str(script))
    deadly = Mesh(RING.vertices, RING.faces[:7])
    rings = [Mesh(RING.vertices + shift, RING.faces) for shift in (0.0, 1.0, 2.0)]
    found = divided([rings[0], deadly, rings[1], deadly, rings[2]])
    assert [None if pieces is None else len(pieces) for pieces in found] == [1, None, 1, None, 1]


def test_too_much_processor_time_ends_the_process(monkeypatch) -> None:
    monkeypatch.setattr(coacd_pieces, "MAX_SECONDS", 0.01)
    assert divided([RING]) == [None]


def test_surfaces_without_time_left_are_neither_divided_nor_remembered(monkeypatch, cache) -> None:
    monkeypatch.setattr(coacd_pieces, "MAX_SECONDS_PER_PROCESS", 1e-3)
    assert divided([RING]) == [None]
    monkeypatch.setattr(coacd_pieces, "MAX_SECONDS_PER_PROCESS", 60.0)
    assert divided([RING]) != [None]


@pytest.mark.parametrize(
    "division",
    [
        "os.kill(os.getpid(), signal.SIGSEGV)",
        "os.abort()",
        "signal.setitimer(signal.ITIMER_PROF, 0.01) or [0 for _ in iter(int, 1)]",
        "raise RuntimeError('not a manifold')",
        "return []",
    ],
)
def test_a_surface_on_which_coacd_fails_is_remembered(monkeypatch, cache, tmp_path, division) -> None:
    replace_coacd(monkeypatch, tmp_path / "fake", division)
    assert divided([RING]) == [None]
    assert len(list(cache.iterdir())) == 1
    monkeypatch.delenv("PYTHONPATH")
    assert divided([RING]) == [None]


@pytest.mark.parametrize(
    ("first", "division"),
    [
        ("raise ImportError('lib_coacd.so is missing')", "pass"),
        ("os.abort()", "pass"),
        ("", "os.kill(os.getpid(), signal.SIGKILL)"),
        ("", "raise MemoryError"),
        ("np.savez = lambda *_, **__: open('/')", "return [(np.eye(3), None)]"),
    ],
    ids=["import fails", "import crashes", "killed", "no memory", "disk error"],
)
def test_a_failure_that_is_not_about_the_surface_is_tried_again(monkeypatch, cache, tmp_path, first, division) -> None:
    replace_coacd(monkeypatch, tmp_path / "fake", division, first)
    assert divided([RING]) == [None]
    assert not cache.exists()
    monkeypatch.delenv("PYTHONPATH")
    assert divided([RING]) != [None]


def test_a_coacd_that_does_not_run_is_started_once(monkeypatch, tmp_path) -> None:
    count = tmp_path / "starts"
    replace_coacd(monkeypatch, tmp_path / "fake", "pass", f"open({str(count)!r}, 'a').write('x'); raise ImportError")
    monkeypatch.setattr(coacd_pieces, "MAX_PROCESSES", 1)
    assert divided([Mesh(RING.vertices + shift, RING.faces) for shift in (0.0, 1.0, 2.0)]) == [None] * 3
    assert count.read_text() == "x"


def test_kinmo_needs_no_coacd() -> None:
    code = "import sys; sys.modules['coacd'] = None; import kinmo; kinmo.Prediction"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_no_surface_needs_no_process(monkeypatch) -> None:
    monkeypatch.setattr(coacd_pieces, "_run_all", lambda *_: pytest.fail("ran"))
    assert divided([]) == []
