"""A test scan as a file, to try `kinmo predict` on."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from scanned_workspace import CPU, FAMILY, Scanned
from trained_workspace import Recorder, contents
from typer.testing import CliRunner

from kinmo.cli.app import app
from kinmo.core.errors import InputError
from kinmo.pipeline.scans.example_scan import ExampleScan
from kinmo.pipeline.scans.predict_scans import PredictScans
from kinmo.scans.files.scan_file import open_scans
from kinmo.scans.files.scan_reader import read_scan


def test_an_example_is_the_test_scan_that_shows_all_parts_best(scanned: Scanned, tmp_path: Path) -> None:
    example = ExampleScan(scanned.workspace, FAMILY, tmp_path / "new" / "scan.npz", scanned.render())
    assert [step for step in example.plan().steps if "scan.npz" in step]
    name = example.run(Recorder()).data["object"]
    test = open_scans(next(path for path in scanned.scans("test") if path.name.startswith(f"{name}-")))
    counts = [min(int((parts == part).sum()) for part in range(test.structure.part_count)) for parts in test.read("parts")]
    np.testing.assert_array_equal(read_scan(example.path).points, test.read("points", int(np.argmax(counts))))
    before = contents(tmp_path / "new")
    example.run(Recorder())
    assert contents(tmp_path / "new") == before
    found = PredictScans(example.path, tmp_path / "out", scanned.workspace, FAMILY, **CPU).run(Recorder())
    assert len(found.data["parts"]) == 2


def test_only_an_earlier_example_is_replaced(scanned: Scanned, tmp_path: Path) -> None:
    np.savez(tmp_path / "points.npz", points=np.zeros((3, 3)))
    (tmp_path / "scan.npz").write_bytes(b"mine")
    for name, problem in (("scan.npz", "exists, and is no example"), ("points.npz", "exists"), ("scan.txt", r"ends in \.npz")):
        example = ExampleScan(scanned.workspace, FAMILY, tmp_path / name, scanned.render())
        for ask in (example.plan, lambda example=example: example.run(Recorder())):
            with pytest.raises(InputError, match=problem):
                ask()
    assert (tmp_path / "scan.npz").read_bytes() == b"mine"


def test_present_scans_are_used_whatever_the_configuration(scanned: Scanned, tmp_path: Path) -> None:
    made = scanned.copied(tmp_path)
    before = contents(made.workspace.path)
    command = ["render", "--category", FAMILY, "--workspace", str(made.workspace.path), "--workers", "1", "--example"]
    for other in (["--config", "small"], ["--seed", "1"]):  # all would be scanned anew
        result = CliRunner().invoke(app, [*command, str(tmp_path / "scan.npz"), *other])
        assert result.exit_code == 0, result.output
        assert contents(made.workspace.path) == before


def test_scans_are_made_only_if_there_are_none(scanned: Scanned, tmp_path: Path) -> None:
    made = scanned.copied(tmp_path)
    example = ExampleScan(made.workspace, FAMILY, tmp_path / "scan.npz", made.render(extra=()))
    made.remove_scans("test")
    before = contents(made.workspace.path)
    for ask in (example.plan, lambda: example.run(Recorder())):
        with pytest.raises(InputError, match=r"expected scans of a test object .*; found 0 other test objects\. Prepare more"):
            ask()
    made.interrupt("train")
    with pytest.raises(InputError, match="scanning was interrupted"):
        example.run(Recorder())
    assert contents(made.workspace.path) == before, "nothing is scanned with other settings"
    shutil.rmtree(made.workspace.scans)
    assert [step.split()[0] for step in example.plan().steps] == ["scan", "write"]
    assert example.run(Recorder()).failed == 0
    assert [step.split()[0] for step in example.plan().steps] == ["write"]
