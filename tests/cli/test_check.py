"""The command `kinmo check` as a user runs it."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from cabinet_results import result_in
from trained_workspace import Recorder, contents

from kinmo.cli.app import main
from kinmo.pipeline.export_results import ExportResults


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with one corrected result as URDF and USD."""
    folder = result_in(tmp_path_factory.mktemp("cabinet"))
    assert ExportResults(folder, ("urdf", "usd")).run(Recorder()).failed == 0
    return folder.parent


def kinmo(line: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of a command line, whose first word is kinmo."""
    monkeypatch.setattr(sys, "argv", line.split())
    code = 0
    try:
        main()
    except SystemExit as ended:
        code = int(ended.code or 0)
    return code, *capfd.readouterr()


def test_a_line_for_each_object_the_totals_and_the_path_are_printed(results, monkeypatch, capfd):
    before = contents(results)
    code, out, err = kinmo(f"kinmo check {results} --simulator usd,pybullet", monkeypatch, capfd)
    assert code == 0 and "checking: 1/1" in err
    assert out.splitlines() == [
        "object   loads  rests  moves  agrees  works  problem",
        "cabinet  yes    yes    yes    yes     yes",
        "URDF in PyBullet: 1 of 1 work",
        "USD in usd-core: 1 of 1 work",
        "1 object: 1 load, 1 rest, 1 move, 1 agree, 1 work",
        str(results / "cabinet"),
    ]
    _, out, _ = kinmo(f"kinmo check {results} --simulator usd", monkeypatch, capfd)
    assert out.splitlines()[1:4:2] == [
        "cabinet  yes    -      -      yes     yes",
        "1 object: 1 load, 1 agree, 1 work",
    ]
    assert kinmo(f"kinmo check {results} --simulator usd --quiet", monkeypatch, capfd)[1] == f"{results / 'cabinet'}\n"
    code, out, _ = kinmo(f"kinmo check {results} --simulator usd --dry-run", monkeypatch, capfd)
    assert code == 0 and out.splitlines()[0] == f"check {results / 'cabinet'}: USD in usd-core"
    assert contents(results) == before


def test_an_object_that_does_not_work_gives_exit_code_1_and_the_reason(results, tmp_path, monkeypatch, capfd):
    folder = tmp_path / "cabinet"
    folder.mkdir()
    (folder / "joints.json").write_bytes((results / "cabinet" / "joints.json").read_bytes())
    code, out, _ = kinmo(f"kinmo check {folder} --simulator usd --json", monkeypatch, capfd)
    data = json.loads(out)
    assert code == 1 and data["works"] == 0
    (found,) = data["results"]
    assert found["loads"] is False and found["rests"] is None and "cabinet.usd is missing" in found["problems"][0]


def test_a_folder_without_results_is_one_line(tmp_path, monkeypatch, capfd):
    code, out, err = kinmo(f"kinmo check {tmp_path}", monkeypatch, capfd)
    assert (code, out) == (1, "")
    remedy = "make exports with kinmo export --format joints_json,urdf to check them"
    assert err == f"kinmo: {tmp_path}: expected a result of kinmo predict, with joints.json, at or below it: {remedy}\n"
