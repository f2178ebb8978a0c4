"""The scripts in examples/ and the Python blocks of the documents run, on folders like those of `make demo`."""

from __future__ import annotations

import ast
import runpy
import sys
from pathlib import Path

import pytest
import trimesh
from cabinet_results import cabinet_prediction
from documents import PAGES, ROOT, code_blocks
from scanned_workspace import FAMILY, Scanned
from trained_workspace import Trained, contents, tiny_config

from kinmo.scans.files.scan_file import open_scans
from kinmo.scans.files.scan_reader import write_points

EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
BLOCKS = [(page, number, block) for page in PAGES for number, block in enumerate(code_blocks(page, "python"))]
MAX_LINES = 50


def run(number: int, *arguments: object, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run an example as a script."""
    (path,) = (path for path in EXAMPLES if path.name.startswith(f"{number}_"))
    monkeypatch.setattr(sys, "argv", [str(path), *map(str, arguments)])
    runpy.run_path(str(path), run_name="__main__")


@pytest.fixture
def demo(trained: Trained, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working directory with the folders that `make demo` leaves."""
    (tmp_path / "demo").mkdir()
    (tmp_path / "demo" / "partnet").symlink_to(trained.shapes)
    trained.copy(tmp_path / "demo")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_are_short_and_need_only_kinmo_and_numpy(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    tree = ast.parse(text)
    imported = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    imported |= {str(node.module) for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert "kinmo" in imported
    assert imported <= {"argparse", "pathlib", "numpy", "kinmo"}
    assert len(text.splitlines()) <= MAX_LINES
    assert f"python examples/{path.name}" in (ast.get_docstring(tree) or "")


def test_an_object_is_predicted(demo: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    run(1, monkeypatch=monkeypatch)
    out = capsys.readouterr().out
    assert "joints" in out and "score" in out
    assert out.splitlines()[-1] == "predicted/joints.json"
    assert (demo / "predicted" / "joints.json").is_file()


def test_an_object_is_moved_and_exported(
    demo: Path, trained: Trained, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run(2, monkeypatch=monkeypatch)
    shape = sorted((trained.shapes / "partnet").iterdir())[-1]
    run(2, shape, "--workspace", trained.workspace.path, "--out", demo / "mine", monkeypatch=monkeypatch)
    out = capsys.readouterr().out
    assert "moved by" in out and "bounding box of the open object" in out
    assert (demo / "exported" / "exported.urdf").is_file() and (demo / "mine" / "mine.urdf").is_file()


def test_networks_are_trained(
    demo: Path, trained: Trained, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    before = contents(demo / "demo" / "workspace" / "models")
    run(3, "--config", tiny_config(demo), monkeypatch=monkeypatch)
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"included: {len(trained.outcomes['prepare'].data['included'])} shapes"
    assert any(line.startswith("gnn_fine: 1 epoch") for line in lines)
    assert lines[-1] == "demo/workspace/models"
    assert contents(demo / "demo" / "workspace" / "models") == before, "the same training has been done"


def test_joints_are_found_in_a_scan(
    scanned: Scanned, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    points = open_scans(next(scanned.scans("test"))).read("points", 0)
    write_points(tmp_path / "scan.npz", points)
    run(4, tmp_path / "scan.npz", "--category", FAMILY, "--workspace", scanned.workspace.path, monkeypatch=monkeypatch)
    out = capsys.readouterr().out
    assert "part 0: " in out and "joint of part 1: revolute, at " in out and " rad" in out


@pytest.mark.usefixtures("demo")
def test_networks_are_evaluated(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    run(5, "--category", "pliers", monkeypatch=monkeypatch)
    lines = capsys.readouterr().out.splitlines()
    assert "parts given" in lines and "hierarchy given" in lines
    assert any(line.startswith("  kinmo: ") and line.endswith("joints are right") for line in lines)
    assert lines[-1] == "demo/workspace/evaluation/pliers"


def write_cabinet(path: Path) -> None:
    """A cabinet with a door, as a .glb with named nodes."""
    scene = trimesh.Scene()
    for name, extents, center in (
        ("bottom", (1.0, 0.1, 0.5), (0.0, 0.05, 0.0)),
        ("top", (1.0, 0.1, 0.5), (0.0, 0.95, 0.0)),
        ("left", (0.1, 0.8, 0.5), (-0.45, 0.5, 0.0)),
        ("right", (0.1, 0.8, 0.5), (0.45, 0.5, 0.0)),
        ("door", (1.0, 1.0, 0.05), (0.0, 0.5, 0.275)),
    ):
        box = trimesh.creation.box(extents, trimesh.transformations.translation_matrix(center))
        scene.add_geometry(box, node_name=name, geom_name=name)
    scene.export(path)


@pytest.mark.parametrize(
    "block", [block for _, _, block in BLOCKS], ids=[f"{path.relative_to(ROOT)}-{number}" for path, number, _ in BLOCKS]
)
def test_python_blocks_of_documents_run(
    block: str, trained: Trained, request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    if "ScanPredictor" in block:
        scanned: Scanned = request.getfixturevalue("scanned")
        write_points(Path("scan.npz"), open_scans(next(scanned.scans("test"))).read("points", 0))
        Path("workspace").symlink_to(scanned.workspace.path)
        block = block.replace('"refrigerator"', f'"{FAMILY}"')
    else:
        trained.copy(tmp_path)
        Path("partnet").symlink_to(trained.shapes)
        write_cabinet(Path("cabinet.glb"))
        block = block.replace(
            'kinmo.train("motion", "workspace")', f'kinmo.train("motion", "workspace", config="{tiny_config(tmp_path)}")'
        )
    if 'load("out/cabinet")' in block or "read_joints_json(" in block:
        cabinet_prediction(tmp_path, ("frame", "door_left", "knob", "front", "box")).save("out/cabinet")
    if "out/cabinet/cabinet." in block:
        cabinet_prediction(tmp_path).export("out/cabinet", formats=["urdf", "mjcf", "usd"])
    exec(compile(block, "block", "exec"), {"__name__": "block"})
