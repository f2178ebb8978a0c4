"""A test scan to try `kinmo predict` on."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from scanned_workspace import CATEGORY, FAMILY, CPU, Scanned
from typer.testing import CliRunner
from trained_workspace import Recorder, contents

from kinmo.cli.app import app
from kinmo.core.errors import InputError
from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.scans.example_scan import ExampleScan
from kinmo.pipeline.scans.predict_scans import PredictScans
from kinmo.pipeline.scans.render_scans import Render
from kinmo.pipeline.scans.scan_dataset import unfinished
from kinmo.scans.files.scan_file import open_scans
from kinmo.scans.files.scan_reader import read_scan


def test_an_example_is_the_test_scan_that_shows_all_parts_best(scanned: Scanned, tmp_path: Path) -> None:
    example = ExampleScan(scanned.workspace, FAMILY, tmp_path / "new" / "scan.npz", scanned.render())
    assert [step for step in example.plan().steps if "scan.npz" in step]
    name = example.run(Recorder()).data["object"]
    test = open_scans(next((scanned.workspace.scans / CATEGORY / "test").glob(f"{name}-*.safetensors")))
    counts = [min(int((parts == part).sum()) for part in range(test.structure.part_count)) for parts in test.read("parts")]
    np.testing.assert_array_equal(read_scan(example.path).points, test.read("points", int(np.argmax(counts))))
    before = contents(tmp_path / "new")
    example.run(Recorder())
    assert contents(tmp_path / "new") == before
    found = PredictScans(example.path, tmp_path / "out", scanned.workspace, FAMILY, **CPU).run(Recorder())
    assert len(found.data["parts"]) == 2
    for taken in ("scan.npz", "points.npz", "scan.txt"):
        (tmp_path / taken).write_bytes(b"mine")
        np.savez(tmp_path / "points.npz", points=np.zeros((3, 3)))
        with pytest.raises(InputError, match=r"in the way|ends in \.npz"):
            ExampleScan(scanned.workspace, FAMILY, tmp_path / taken, scanned.render()).plan()
    assert (tmp_path / "scan.npz").read_bytes() == b"mine"


def test_an_example_is_scanned_only_where_there_are_no_scans(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace = Workspace(tmp_path / "workspace")
    before = contents(workspace.path)
    command = ["render", "--category", FAMILY, "--workspace", str(workspace.path), "--workers", "1", "--example"]
    for other in (["--config", "small"], ["--seed", "1"]):  # by which all would be scanned anew
        result = CliRunner().invoke(app, [*command, str(tmp_path / "scan.npz"), *other])
        assert result.exit_code == 0, result.output
        assert contents(workspace.path) == before
    example = ExampleScan(workspace, FAMILY, tmp_path / "scan.npz", Render(workspace, scanned.config, FAMILY, beside=()))
    shutil.rmtree(workspace.scans / CATEGORY / "test")
    before = contents(workspace.path)
    for ask in (example.plan, lambda: example.run(Recorder())):
        with pytest.raises(
            InputError, match=r"expected scans of a test object .* there is none, but \d+ other test objects?; "
        ):
            ask()
    assert contents(workspace.path) == before, "what was scanned stays"
    unfinished(workspace, CATEGORY, "train").touch()
    before = contents(workspace.path)
    with pytest.raises(InputError, match="scanning was stopped"):
        example.run(Recorder())
    assert contents(workspace.path) == before, "nor is it made in another way than was begun"
    shutil.rmtree(workspace.scans)
    assert [step.split()[0] for step in example.plan().steps] == ["scan", "write"]
    assert example.run(Recorder()).failed == 0
    assert [step.split()[0] for step in example.plan().steps] == ["write"]
