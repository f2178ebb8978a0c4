"""Python blocks of the documents run as they stand."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
import trimesh
from documents import PAGES, ROOT, code_blocks
from scanned_workspace import CATEGORY, Scanned
from trained_workspace import Recorder, Trained, tiny_config

import kinmo
from kinmo.pipeline.scans.example_scan import ExampleScan

WITH_CODE = [page for page in PAGES if code_blocks(page, "python")]


def write_cabinet(path: Path) -> None:
    """A cabinet with a door, as nodes of a binary glTF file."""
    scene = trimesh.Scene()
    for name, extents, center in (("body", (0.6, 1.0, 0.5), (0, 0, 0)), ("door", (0.6, 1.0, 0.02), (0, 0, 0.26))):
        box = trimesh.creation.box(extents, trimesh.transformations.translation_matrix(center))
        scene.add_geometry(box, node_name=name, geom_name=name)
    scene.export(path)


@pytest.mark.parametrize("page", WITH_CODE, ids=lambda page: str(page.relative_to(ROOT)))
def test_the_python_blocks_of_a_page_run_in_order(
    page: Path, trained: Trained, scanned: Scanned, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = tiny_config(tmp_path)
    monkeypatch.setattr("kinmo.config.loading._builtin_path", lambda name: config)
    monkeypatch.chdir(tmp_path)
    code = "\n".join(code_blocks(page, "python")).replace('"dishwasher"', f'"{CATEGORY}"')
    shutil.copytree((scanned if "ScanPredictor" in code else trained).workspace.path, "workspace")
    shutil.copytree(trained.shapes, "partnet")
    write_cabinet(Path("cabinet.glb"))
    if "scan.npz" in code:
        ExampleScan(scanned.workspace, CATEGORY, Path("scan.npz"), scanned.render()).run(Recorder())
    if "joints.json" in code:
        kinmo.Predictor("workspace", device="cpu").predict(kinmo.load("cabinet.glb")).save("out/cabinet")
    exec(compile(code, str(page), "exec"), {})
