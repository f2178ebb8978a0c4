"""The command `kinmo export` as a user runs it."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import pytest
from cabinet_results import result_in
from documents import ROOT, code_blocks
from predicted_cabinet import write_cabinet_glb
from trained_workspace import contents
from typer.testing import CliRunner

from kinmo.cli.app import app, main
from kinmo.io.writers import WRITERS

GUIDE = ROOT / "docs" / "guide" / "correct.md"
PLAIN = {"TERM": "dumb", "NO_COLOR": "1", "COLUMNS": "140"}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The result out/cabinet in the working directory, with corrections that are not applied yet."""
    monkeypatch.chdir(tmp_path)
    return result_in(tmp_path).relative_to(tmp_path)


def kinmo(line: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of a command line, whose first word is kinmo."""
    monkeypatch.setattr(sys, "argv", line.split())
    code = 0
    try:
        main()
    except SystemExit as ended:
        code = int(ended.code or 0)
    return code, *capsys.readouterr()


Run = tuple[pytest.MonkeyPatch, pytest.CaptureFixture[str]]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    return monkeypatch, capsys


def test_the_joints_and_the_path_are_printed(folder: Path, run: Run) -> None:
    code, out, err = kinmo(f"kinmo export {folder}", *run)
    assert code == 0 and "cabinet: knob has no part left: dropped" in err
    assert out.splitlines() == [
        "cabinet (category unknown)",
        "  door: hinge, 0 to 110°, corrected by hand",
        "  drawer: slider, 0 to 0.3 m, corrected by hand",
        "1 result, 2 joints, 1 corrected, 0 skipped",
        str(folder),
    ]
    assert kinmo(f"kinmo export {folder} --quiet", *run)[1] == f"{folder}\n"
    data = json.loads(kinmo(f"kinmo export {folder} --json", *run)[1])
    assert data["skipped"] == [] and data["results"][0]["joints"] == 2


def test_a_dry_run_changes_nothing(folder: Path, run: Run) -> None:
    before = contents(Path())
    for target in ("", " -o robots"):
        code, out, _ = kinmo(f"kinmo export {folder}{target} --dry-run", *run)
        place = folder if not target else Path("robots/cabinet")
        assert code == 0 and out.splitlines()[0] == f"write {place}: urdf, joints_json, corrected by overrides.toml"
    assert contents(Path()) == before


@pytest.mark.parametrize("line", [line for block in code_blocks(GUIDE, "sh") for line in block.splitlines()])
def test_the_commands_of_the_guide_run(line: str, folder: Path, run: Run) -> None:
    line = line.split("#")[0]
    code, out, _ = kinmo(line, *run)
    assert code == 0
    path = Path(out.splitlines()[-1])
    formats = re.findall(r"--format (\w+)", line)
    expected = {"urdf": "cabinet.urdf", "partnet_mobility": "mobility_v2.json"}
    assert all((path / expected[name]).is_file() for name in formats)
    assert formats or (path / "joints.json").read_text(encoding="utf-8").count('"override"')
    assert kinmo(line, *run)[0] == 0, "it can be run again"


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (
            "[bodies.dor]\nflip = true",
            "bodies.dor: there is no body dor (did you mean door?); there are base, door, knob, front",
        ),
        ("[bodies.door]\nrange = 110", 'bodies.door.range: expected two numbers, such as [0, 90], or "unlimited"'),
    ],
)
def test_a_mistake_is_one_line_and_exit_code_1(folder: Path, run: Run, overrides: str, message: str) -> None:
    (folder / "overrides.toml").write_text(overrides, encoding="utf-8")
    before = contents(folder)
    line = f"{folder / 'overrides.toml'}: {message}"
    assert kinmo(f"kinmo export {folder} --quiet", *run) == (1, "", f"skipped: {line}\n")
    assert kinmo(f"kinmo export {folder} --dry-run", *run) == (1, f"{line}\n", "")
    assert contents(folder) == before


def test_a_changed_or_missing_file_is_one_line_and_exit_code_1(folder: Path, run: Run) -> None:
    before = contents(folder)
    source = Path("cabinet.glb").absolute()
    write_cabinet_glb(source, ("frame", "lid", "knob", "front", "box"))
    remedy = "run kinmo predict again, which keeps overrides.toml"
    code, _, err = kinmo(f"kinmo export {folder} --quiet", *run)
    assert (code, err) == (1, f"skipped: {source}: has changed since the prediction in {folder}: {remedy}\n")
    source.unlink()
    code, _, err = kinmo(f"kinmo export {folder} --quiet", *run)
    assert (code, err) == (1, f"skipped: {source}: missing: name the file of the shape by --source\n")
    assert contents(folder) == before
    write_cabinet_glb(Path("moved.glb"))
    assert kinmo(f"kinmo export {folder} --source moved.glb", *run)[0] == 0
    assert kinmo(f"kinmo export {folder}", *run)[0] == 0, "the new place is remembered"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("nowhere", "nowhere: no such folder"),
        ("out --formats lego", f"formats: unknown format lego; expected one of {', '.join(WRITERS)}"),
        ("out -o cabinet.glb", "cabinet.glb: is a file: name a folder"),
        ("out -o out/cabinet", "--out: lies in the result out/cabinet: name a folder elsewhere"),
    ],
)
def test_wrong_arguments_are_one_line(folder: Path, run: Run, arguments: str, message: str) -> None:
    before = contents(Path())
    assert kinmo(f"kinmo export {arguments}", *run) == (1, "", f"kinmo: {message}\n")
    assert contents(Path()) == before


def test_an_empty_package_gives_relative_paths(folder: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    urdf = Path("ros/mine/mine.urdf")
    assert kinmo(f"kinmo export {folder} --format urdf,joints_json --package mine -o ros", *run)[0] == 0
    assert "package://mine/" in urdf.read_text(encoding="utf-8")
    monkeypatch.setattr(sys, "argv", ["kinmo", "export", "ros/mine", "--package", ""])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code in (0, None)
    assert "package://" not in urdf.read_text(encoding="utf-8")


def test_a_folder_with_other_files_stays(folder: Path, run: Run) -> None:
    Path("robots/cabinet").mkdir(parents=True)
    Path("robots/cabinet/notes.txt").touch()
    code, _, err = kinmo(f"kinmo export {folder} -o robots --quiet", *run)
    assert code == 1 and err.startswith("skipped: robots/cabinet: exists, and is no export of the same result")
    assert [path.name for path in Path("robots/cabinet").iterdir()] == ["notes.txt"]


def test_help_and_guide_name_the_same_options_and_fields() -> None:
    text = " ".join(CliRunner().invoke(app, ["export", "--help"], env=PLAIN).output.split())
    guide = GUIDE.read_text(encoding="utf-8")
    assert "docs/guide/correct.md" in text
    for option in set(re.findall(r"(?<!`)--[a-z-]+", guide)):
        assert option in text
    for field in ("type", "axis", "origin", "range", "parent", "parts", "name"):
        assert field in text and re.search(rf"^{field} = ", guide, re.MULTILINE)
