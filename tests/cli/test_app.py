"""The program as a user starts it."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import get_args

import pytest
from typer.main import get_command
from typer.testing import CliRunner

from kinmo._core import __version__
from kinmo.cli.app import app, main

COMMANDS = sorted(get_command(app).commands)  # type: ignore[attr-defined]
WITHOUT_WORKERS = ("render-preview", "report", "view")
"""Commands that use one process."""
PLAIN = {"TERM": "dumb", "NO_COLOR": "1", "COLUMNS": "140"}


def test_help_loads_no_slow_library() -> None:
    code = (
        "import sys\nfrom typer.testing import CliRunner\nfrom kinmo.cli.app import app\n"
        "assert CliRunner().invoke(app, ['--help']).exit_code == 0\n"
        "print(*{'torch', 'scipy', 'trimesh', 'pybullet', 'jinja2', 'sklearn', 'numpy'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.strip() == ""


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help_with_examples_and_the_common_options(command: str) -> None:
    result = CliRunner().invoke(app, [command, "--help"], env=PLAIN)
    assert result.exit_code == 0
    assert "For example:" in result.output
    assert f"kinmo {command}" in result.output.split("For example:")[1]
    for option in ("--workspace", "--device", "--seed", "--dry-run", "--quiet", "--json"):
        assert option in result.output
    assert ("--workers" in result.output) == (command not in WITHOUT_WORKERS)


@pytest.mark.parametrize("command", COMMANDS)
def test_the_examples_of_the_help_parse(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = CliRunner().invoke(app, [command, "--help"], env=PLAIN).output.split("For example:")[1].split("╭")[0]
    examples = re.findall(rf"kinmo {command}[^\n]*", text)
    assert examples
    for example in examples:
        arguments = [*example.split(" >")[0].split()[1:], "--dry-run", "--workspace", str(tmp_path / "workspace")]
        result = CliRunner().invoke(app, arguments, env=PLAIN)
        assert result.exit_code in ((0,) if command == "synth" else (0, 1)), result.output  # 1: there are no files
        assert result.exception is None or isinstance(result.exception, SystemExit)


def test_no_command_shows_the_help() -> None:
    result = CliRunner().invoke(app, [], env=PLAIN)
    assert all(command in result.output for command in COMMANDS)


def test_the_version_is_that_of_the_package() -> None:
    assert CliRunner().invoke(app, ["--version"]).output == f"kinmo {__version__}\n"


@pytest.mark.parametrize(
    "arguments",
    [
        ["nonsense"],
        ["synth"],
        ["synth", "x", "--count", "none"],
        ["synth", "x", "--count", "0"],
        ["predict", "x.stl", "--up", "z", "--front", "-z"],
    ],
)
def test_wrong_usage_is_exit_code_2(arguments: list[str]) -> None:
    assert CliRunner().invoke(app, arguments).exit_code == 2


@pytest.mark.parametrize(
    "arguments", [["synth", ""], ["prepare", ""], ["eval", "--workspace", ""], ["export", "--package", "", ""]]
)
def test_an_empty_argument_is_not_the_current_folder(
    arguments: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["kinmo", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    assert capsys.readouterr().err == "kinmo: an argument is empty: is a variable not set?\n"
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("command", ["predict", "export"])
def test_formats_have_both_spellings(command: str) -> None:
    for option in ("--format", "--formats"):
        result = CliRunner().invoke(app, [command, "nowhere", option, "urdf"])
        assert result.exit_code == 1 and "nowhere: no such" in result.output


ONLY_WORKSPACE = "applies only to the workspace's own shapes and scans, not to FILES"


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("train all --setting supervised", "--setting: applies only to kinmo train ancsh"),
        ("train gnn --method paper", "--method: applies only to kinmo train all and ancsh"),
        (
            "train ancsh --method paper --setting supervised",
            "--method: applies only to the setting semi-weakly, not to supervised",
        ),
        (
            "train ancsh --from elsewhere --setting self-training",
            "--from: ancsh cannot start from trained weights; use it with all, motion or kinmo",
        ),
        ("train ancsh --from elsewhere", "--from: ancsh cannot start from trained weights; use it with all, motion or kinmo"),
        ("predict shapes --depth-scale 1000", "--depth-scale: applies only to scans; give --category too, and name a scan"),
        ("predict scan.npz --category door --up z", "--up: applies only to shapes; remove it, or name a shape"),
        (
            "predict a.npz --category door --metres-per-unit 2",
            "--metres-per-unit: applies only to shapes; remove it, or name a shape",
        ),
        ("predict a.npz --category door --front y", "--front: applies only to shapes; remove it, or name a shape"),
        ("predict a.npz --category door --labels l.npy", "--labels: applies only to shapes; remove it, or name a shape"),
        ("predict a.npz --category door --cluster auto", "--cluster: applies only to shapes; remove it, or name a shape"),
        ("predict shapes --intrinsics 1,1,1,1", "--intrinsics: applies only to scans; give --category too, and name a scan"),
        ("render --example scan.npz", "--example: expected --category too: the category of the scan"),
        ("synth shapes --layout dsg_net --oracle", "--oracle: applies only to --layout partnet"),
        ("table 2 --method paper --from elsewhere", "--from: paper cannot start from trained weights; use it with kinmo"),
        ("table sensors --method paper", "--method: sensors has no rows with pseudo labels of paper"),
        ("eval urdfs --truth shapes --protocol ancsh", f"--protocol: {ONLY_WORKSPACE}"),
        ("eval urdfs --truth shapes --method paper", f"--method: {ONLY_WORKSPACE}"),
        ("eval urdfs --truth shapes --ablations", f"--ablations: {ONLY_WORKSPACE}"),
        ("eval urdfs --truth shapes --hidden-names", f"--hidden-names: {ONLY_WORKSPACE}"),
        ("eval urdfs --truth shapes --details", f"--details: {ONLY_WORKSPACE}"),
    ],
)
def test_an_option_without_effect_is_refused(command: str, message: str) -> None:
    result = CliRunner().invoke(app, command.split())
    assert result.exit_code == 1
    assert f"kinmo: {message}" in result.output


@pytest.mark.parametrize("option", ["--metres-per-unit", "--depth-scale"])
@pytest.mark.parametrize("value", ["0", "-1", "inf", "1e300", "nan"])
def test_absurd_scales_are_refused(option: str, value: str) -> None:
    result = CliRunner().invoke(app, ["predict", "shapes", option, value])
    assert result.exit_code == 2
    assert option in result.output


def test_choices_of_options_equal_those_of_the_program() -> None:
    """The command line lists choices a second time because help must start without heavy imports."""
    from kinmo.api.stages import Networks
    from kinmo.cli.options import AxisName, MethodName, ProtocolName
    from kinmo.cli.synth import MAX_SHAPES, LayoutName
    from kinmo.cli.table import TableName
    from kinmo.cli.train import NetworksName, SettingName
    from kinmo.core.frames import Axis
    from kinmo.experiments.scan_tables.table_rows import TABLES
    from kinmo.methods import METHOD_MODELS
    from kinmo.pipeline.motion_models import GROUPS
    from kinmo.pipeline.scans.scan_scores import PROTOCOLS
    from kinmo.pipeline.scans.training_settings import Setting
    from kinmo.synth import generate
    from kinmo.synth.writers import WRITERS

    assert {each.value for each in LayoutName} == WRITERS.keys()
    assert set(get_args(MethodName)) == METHOD_MODELS.keys()
    assert get_args(AxisName) == get_args(Axis)
    assert set(get_args(NetworksName)) == set(get_args(Networks)) == GROUPS.keys() | {"all", "ancsh"}
    assert set(get_args(SettingName)) == set(get_args(Setting))
    assert set(get_args(TableName)) == TABLES.keys()
    assert set(get_args(ProtocolName)) == set(PROTOCOLS)
    assert MAX_SHAPES == generate.MAX_SHAPES


def test_the_environment_can_name_the_workspace(tmp_path: Path) -> None:
    assert "KINMO_WORKSPACE" in CliRunner().invoke(app, ["synth", "--help"], env=PLAIN).output
    result = CliRunner().invoke(app, ["report"], env={**PLAIN, "KINMO_WORKSPACE": str(tmp_path / "mine")})
    assert result.exit_code == 1
    assert result.output == f"kinmo: {tmp_path / 'mine' / 'prepared' / 'index.jsonl'}: missing: run kinmo prepare first\n"


@pytest.mark.parametrize("arguments", [["eval", "out"], ["eval", "--truth", "shapes"], ["predict", "scan.npz"]])
def test_options_that_belong_together_are_wrong_usage_alone(
    arguments: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("scan.npz").touch()
    assert CliRunner().invoke(app, arguments).exit_code == 2


def test_a_whole_run_prints_the_path_of_its_result_last(tmp_path: Path) -> None:
    shapes, workspace = tmp_path / "partnet", tmp_path / "workspace"
    common = ["--workspace", str(workspace), "--workers", "1"]
    for command, path in (
        (["synth", str(shapes), "--count", "1", "--family", "pliers"], shapes),
        (["prepare", str(shapes)], workspace / "prepared"),
        (["report"], workspace / "report" / "index.html"),
    ):
        options = common if command[0] != "report" else common[:2]
        result = CliRunner().invoke(app, [*command, *options])
        assert result.exit_code == 0, result.output
        assert result.stdout.splitlines()[-1] == str(path)
        quiet = CliRunner().invoke(app, [*command, *options, "--quiet"])
        assert quiet.output.splitlines() == [str(path)]
        json.loads(CliRunner().invoke(app, [*command, *options, "--json"]).stdout)


def test_preparing_and_reporting_load_no_network_library(tmp_path: Path) -> None:
    code = (
        "import sys\nfrom typer.testing import CliRunner\nfrom kinmo.cli.app import app\n"
        f"for command in (['prepare', {str(tmp_path)!r}], ['report']):\n"
        f"    CliRunner().invoke(app, [*command, '--workspace', {str(tmp_path / 'workspace')!r}])\n"
        "print(*{'torch', 'sklearn', 'pybullet'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120)
    assert done.stdout.strip() == ""
