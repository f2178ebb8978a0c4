"""The stage `check`: results that work, results that do not, and the reasons."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from cabinet_results import result_in
from trained_workspace import Recorder, contents

import kinmo
from kinmo.core.errors import InputError
from kinmo.pipeline.check_results import CheckResults
from kinmo.pipeline.export_results import ExportResults
from kinmo.pipeline.result_check import SIMULATORS


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A corrected result for a cabinet as URDF, MJCF and USD."""
    folder = result_in(tmp_path_factory.mktemp("cabinet"))
    assert ExportResults(folder, ("urdf", "mjcf", "usd")).run(Recorder()).failed == 0
    return folder


@pytest.fixture
def result(good: Path, tmp_path: Path) -> Path:
    """A copy of the result to damage."""
    return Path(shutil.copytree(good, tmp_path / "out" / "cabinet"))


def edit(file: Path, pattern: str, new: str) -> None:
    text = file.read_text(encoding="utf-8")
    changed = re.sub(pattern, new, text, count=1, flags=re.DOTALL)
    assert changed != text
    file.write_text(changed, encoding="utf-8")


def problems(result: Path, *simulators: str) -> list[str]:
    outcome = CheckResults(result, simulators).run(Recorder())
    (found,) = outcome.data["results"]
    assert outcome.failed == int(not found["works"]) and bool(found["problems"]) != found["works"]
    return found["problems"]


def test_a_good_object_works_in_every_simulator(good: Path) -> None:
    before = contents(good)
    outcome = CheckResults(good).run(Recorder())
    assert outcome.failed == 0 and outcome.path == good and contents(good) == before
    (found,) = outcome.data["results"]
    assert {test: found[test] for test in ("loads", "rests", "moves", "agrees", "works")} == dict.fromkeys(
        ("loads", "rests", "moves", "agrees", "works"), True
    )
    assert [(check["format"], check["simulator"]) for check in found["checks"]] == [
        ("urdf", "mujoco"), ("urdf", "pybullet"), ("mjcf", "mujoco"), ("usd", "usd"),
    ]  # fmt: skip
    assert [check["rests"] for check in found["checks"]] == [True, True, True, None]
    assert outcome.text.splitlines() == [
        "object   loads  rests  moves  agrees  works  problem",
        "cabinet  yes    yes    yes    yes     yes",
        "URDF in MuJoCo: 1 of 1 work",
        "URDF in PyBullet: 1 of 1 work",
        "MJCF in MuJoCo: 1 of 1 work",
        "USD in usd-core: 1 of 1 work",
        "1 object: 1 load, 1 rest, 1 move, 1 agree, 1 work",
    ]


def test_corrections_that_are_only_saved_come_with_the_remedy(result: Path) -> None:
    edit(result / "overrides.toml", "flip = true", "flip = false")
    kinmo.Prediction.load(result).with_overrides(result / "overrides.toml").save(result)
    (found,) = problems(result, "usd")
    assert found.startswith("USD in usd-core does not agree: door is off by ")
    assert found.endswith(" from joints.json: run kinmo export again")
    assert ExportResults(result).run(Recorder()).failed == 0
    assert problems(result, "usd") == []


def test_a_result_without_collision_geometry_is_named(result: Path) -> None:
    ExportResults(result, ("urdf",), collision="none").run(Recorder())
    recorder = Recorder()
    CheckResults(result, ("mujoco",)).run(recorder)
    assert recorder.notes[-1] == "cabinet: without collision geometry (--collision none), so contacts were not tested"


def test_a_missing_mesh_is_named(result: Path) -> None:
    (result / "meshes" / "door.obj").unlink()
    found = problems(result, "mujoco", "pybullet")
    titles = ["URDF in PyBullet", "MJCF in MuJoCo"]  # MuJoCo does not read what a URDF draws
    assert [each.split(" does not load: ")[0] for each in found] == titles and all("door.obj" in each for each in found)


def test_a_missing_file_comes_with_the_command_that_writes_it(result: Path) -> None:
    (result / "cabinet.urdf").unlink()
    found = problems(result, "pybullet")
    assert found == [
        f"URDF in PyBullet does not load: cabinet.urdf is missing: kinmo export {result} --format urdf writes it again"
    ]


@pytest.mark.parametrize("simulator", ["mujoco", "pybullet"])
def test_a_turned_axis_does_not_agree(result: Path, simulator: str) -> None:
    edit(result / "cabinet.urdf", r'(<joint name="door_joint".*?<axis xyz=)"[^"]*"', r'\1"1 0 0"')
    edit(result / "cabinet.xml", r'(<joint name="door_joint"[^>]*axis=)"[^"]*"', r'\1"1 0 0"')
    found = [each for each in problems(result, simulator) if "does not agree" in each]
    assert found and all(": door is off by " in each for each in found)


def add_box(result: Path, link: str, size: str, place: str) -> None:
    """Add a collision box to a link of the URDF."""
    box = f'<collision name="added"><origin xyz="{place}" /><geometry><box size="{size}" /></geometry></collision>'
    edit(result / "cabinet.urdf", rf'(<link name="{link}">.*?)</link>', rf"\1{box}</link>")


def test_links_that_overlap_do_not_rest(result: Path) -> None:
    add_box(result, "drawer", "0.1 0.1 0.6", "-0.23 0 0.3")  # in the door
    found = problems(result, "mujoco", "pybullet")
    for title in ("URDF in MuJoCo", "URDF in PyBullet"):
        assert any(each.startswith(f"{title} does not rest: ") for each in found)


def test_a_blocked_joint_does_not_move(result: Path) -> None:
    add_box(result, "base", "0.02 3 3", "-0.4 0 0")  # a wall in front of the drawer, which comes out along -x
    assert any(each.startswith("URDF in MuJoCo does not move: drawer_joint reaches ") for each in problems(result, "mujoco"))


def test_a_usd_file_is_validated(result: Path) -> None:
    from pxr import Usd, UsdPhysics

    stage = Usd.Stage.Open(str(result / "cabinet.usd"))
    (door,) = (prim for prim in stage.Traverse() if prim.GetName() == "door_joint")
    UsdPhysics.RevoluteJoint(door).GetAxisAttr().Set("X")
    stage.Save()
    assert problems(result, "usd")[0].startswith("USD in usd-core does not agree: door is off by ")
    UsdPhysics.Joint(door).GetBody1Rel().SetTargets(["/nowhere"])
    stage.Save()
    assert problems(result, "usd")[0].startswith("USD in usd-core does not load: ")
    (result / "cabinet.usd").write_bytes(b"PXR-USDC")
    assert problems(result, "usd")[0].startswith("USD in usd-core does not load: ")


@pytest.mark.parametrize(
    ("module", "problem"),
    [
        ("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", "crashed the simulator (SIGSEGV)"),
        ("import time; time.sleep(600)", "takes more than 8 s: give it more by --time-limit"),
        ("raise RuntimeError('no licence')", "ended with an error: RuntimeError: no licence"),
    ],
)
@pytest.mark.parametrize("workers", [1, 2])
def test_a_simulator_that_fails_is_one_line(
    result: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, module: str, problem: str, workers: int
) -> None:
    (tmp_path / "fake").mkdir()
    (tmp_path / "fake" / "pybullet.py").write_text(module, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path / "fake")
    stage = CheckResults(result, ("pybullet", "usd"), workers, seconds=8.0)
    (found,) = stage.run(Recorder()).data["results"]
    assert found["problems"] == [
        f"URDF in PyBullet {problem}",
        "USD in usd-core was not tested, as the test before it did not end",
    ]


@pytest.mark.parametrize(
    ("change", "field", "problem"),
    [
        (lambda data: data.pop("bodies"), "bodies", "expected at least one body"),
        (lambda data: data.update(bodies=[]), "bodies", "expected at least one body"),
        (lambda data: data.update(bodies={"door": 1}), "bodies", "expected a list"),
        (lambda data: data["bodies"][1].pop("name"), "bodies[1].name", "expected a text"),
        (lambda data: data["shape"].update(up=[0, 0, 0]), "shape.up", "expected a unit vector"),
        (lambda data: data["shape"].update(diagonal=0), "shape.diagonal", "expected a positive number"),
        (lambda data: data["export"].update(name="../cabinet"), "export.name", "expected a name of a file without a folder"),
        (lambda data: data.update(schema_version=99), "schema_version", "expected 1"),
    ],
)
def test_what_is_wrong_with_a_damaged_file_is_one_line(
    result: Path, change: Callable[[dict[str, Any]], object], field: str, problem: str
) -> None:
    file = result / "joints.json"
    data = json.loads(file.read_text(encoding="utf-8"))
    change(data)
    file.write_text(json.dumps(data), encoding="utf-8")
    assert problems(result, "usd") == [f"{file}: {field}: {problem}: run kinmo predict again, which keeps overrides.toml"]


def test_a_link_that_the_file_has_not_is_named(result: Path) -> None:
    edit(result / "joints.json", r'"name": "door"', '"name": "gate"')
    (found,) = problems(result, "usd")
    assert found.startswith("USD in usd-core does not agree: joints.json has no link door")


def test_one_bad_result_stops_no_other(result: Path) -> None:
    for name in ("bad", "none"):
        shutil.copytree(result, result.parent / name)
    (result.parent / "bad" / "joints.json").write_text("{", encoding="utf-8")
    data = json.loads((result / "joints.json").read_text(encoding="utf-8"))
    data["export"]["formats"] = ["joints_json"]
    (result.parent / "none" / "joints.json").write_text(json.dumps(data), encoding="utf-8")
    outcome = CheckResults(result.parent, ("usd",)).run(Recorder())
    assert outcome.failed == 2 and outcome.path == result.parent
    bad, works, none = outcome.data["results"]
    assert works["works"] and works["problems"] == []
    assert bad["problems"][0].startswith(f"{result.parent / 'bad' / 'joints.json'}: ")
    assert none["problems"] == [
        f"{result.parent / 'none'}: has no file that usd-core can read: kinmo export {result.parent / 'none'} --format usd "
        "writes one"
    ]
    assert outcome.text.splitlines()[-1] == "3 objects: 1 of 1 load, 1 of 1 agree, 1 work"


def test_a_plan_names_the_files_and_simulators(result: Path) -> None:
    plan = CheckResults(result, ("mujoco", "usd")).plan()
    assert plan.steps == (f"check {result}: URDF in MuJoCo, MJCF in MuJoCo, USD in usd-core",)
    assert plan.seconds > 0.0 and plan.impossible == ()


def test_missing_simulators_are_named_with_a_remedy(result: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("kinmo.pipeline.result_check.find_spec", lambda module: None if module != "pxr" else module)
    recorder = Recorder()
    CheckResults(result).run(recorder)
    assert "not tested in MuJoCo, which is not installed: pip install 'kinmo[sim]'" in recorder.notes
    with pytest.raises(InputError, match=r"^--simulator: MuJoCo is not installed: pip install 'kinmo\[sim\]'$"):
        CheckResults(result, ("mujoco",)).run(Recorder())
    monkeypatch.setattr("kinmo.pipeline.result_check.find_spec", lambda module: None)
    with pytest.raises(InputError, match="--simulator: none is installed"):
        CheckResults(result).run(Recorder())


def test_what_cannot_be_checked_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    assert set(SIMULATORS) == {"mujoco", "pybullet", "usd"}
    for stage, message in (
        (CheckResults(tmp_path / "nowhere"), "nowhere: no such folder"),
        (CheckResults(tmp_path / "empty"), r"empty: expected a result of kinmo predict, with joints\.json, at or below it"),
        (
            CheckResults(tmp_path, ("mujko",)),
            r"--simulator: unknown: mujko \(did you mean mujoco\?\); expected mujoco, pybullet",
        ),
    ):
        with pytest.raises(InputError, match=message):
            stage.run(Recorder())
