"""Predictions for users' own scans: parts, joints and a picture."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from scanned_workspace import CATEGORY, CPU, FAMILY, Scanned
from trained_workspace import Recorder, contents
from typer.testing import CliRunner

from kinmo.cli.app import app
from kinmo.core.errors import InputError
from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.scans.example_scan import ExampleScan
from kinmo.pipeline.scans.predict_scans import PredictScans
from kinmo.pipeline.scans.scan_dataset import open_scan_dataset
from kinmo.pipeline.scans.scan_networks import ScanRun
from kinmo.pipeline.scans.train_scans import TrainScans
from kinmo.scans.files.camera_intrinsics import Intrinsics
from kinmo.scans.files.scan_file import open_scans
from kinmo.scans.rendering.renderers import NO_PART


def test_a_users_scan_gives_parts_joints_and_a_picture(scanned: Scanned, tmp_path: Path) -> None:
    points = open_scans(next(scanned.scans("test"))).read("points", 0)
    np.savez(tmp_path / "seen.npz", points=np.vstack([points, [[0.0, 0.0, -1.0], [0.0, 0.0, 90.0]]]))
    observer = Recorder()
    found = PredictScans(tmp_path / "seen.npz", tmp_path / "out", scanned.workspace, FAMILY, **CPU).run(observer)
    assert observer.notes == [
        f"1 of {len(points) + 2} points are ignored: they are {why}"
        for why in ("not before the camera (z > 0)", "far from all others")
    ]
    for part in found.data["parts"]:
        share = part["inliers"]
        agree = "not found" if share is None else f"{share:.0%} of them agree on the pose"
        assert f"part {part['id']}: {part['points']} points, {agree}\n" in found.text
    document = json.loads((tmp_path / "out" / "seen.json").read_text())
    assert document == found.data
    assert [joint["kind"] for joint in document["joints"]] == ["R"]
    assert sum(part["points"] for part in document["parts"]) == len(points), "of the scan's own points"
    assert (tmp_path / "out" / "seen.svg").read_text().startswith("<svg")
    with np.load(tmp_path / "out" / "seen.parts.npz") as labelled:
        np.testing.assert_array_equal(labelled["points"][:-1], points[labelled["places"][:-1]])
        assert labelled["parts"][-1] == -1, "an outlier"
        counts = [int((labelled["parts"] == part["id"]).sum()) for part in document["parts"]]
        assert sum(counts) == len(points)
        assert counts == [part["points"] for part in document["parts"]]


def test_every_scan_of_a_folder_is_predicted_as_if_it_were_alone(scanned: Scanned, tmp_path: Path) -> None:
    seen = open_scans(next(scanned.scans("test"))).read("points")
    scans = tmp_path / "scans"
    for name, points in (("first.npz", seen[0]), ("near/second.npz", seen[1]), ("near/second.npy", seen[0])):
        (scans / name).parent.mkdir(parents=True, exist_ok=True)
        np.save(scans / name, points) if name.endswith("npy") else np.savez(scans / name, points=points)
    (scans / "broken.ply").write_text("ply")
    (scans / "notes.txt").write_text("of the camera")
    np.save(scans / ".hidden.npy", seen[0])
    (scans / "near" / "round").symlink_to(scans)
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({10**12}, 3), }}".ljust(117) + "\n"
    (scans / "vast.npy").write_bytes(b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header.encode())
    observer = Recorder()
    stage = PredictScans(scans, scans / "found", scanned.workspace, FAMILY, **CPU)
    assert "5 scans below" in stage.plan().steps[0]
    outcome = stage.run(observer)
    names = [Path(document["scan"]).name for document in outcome.data["scans"]]
    assert names == ["first.npz", "second.npy", "second.npz"]
    assert outcome.failed == len(outcome.data["skipped"]) == 2
    assert {path.name for path in (scans / "found" / "near").iterdir()} == {
        f"second.{ending}.{what}" for ending in ("npy", "npz") for what in ("json", "svg", "parts.npz")
    }
    assert [line for line in outcome.data["skipped"] if "vast.npy: expected arrays of NumPy" in line]
    assert [line for line in outcome.data["skipped"] if "broken.ply: expected a whole PLY file" in line]
    assert observer.notes[0] == "near/round: a link to a folder, which is skipped: name the folder itself"
    assert [f"skipped: {line}" for line in outcome.data["skipped"]] == observer.notes[1:]
    assert outcome.text.splitlines()[0].startswith("first.npz: part 1 R, state ")
    assert outcome.text.splitlines()[1].startswith("near/second.npy: part 1 R")
    assert outcome.text.splitlines()[-1] == "3 scans, 2 skipped"
    alone = PredictScans(scans / "near" / "second.npy", tmp_path / "alone", scanned.workspace, FAMILY, **CPU).run(Recorder())
    assert alone.data == outcome.data["scans"][1]
    again = stage.run(Recorder())
    assert again.data == outcome.data, "results are no scans"
    arguments = [
        "--category",
        FAMILY,
        "--workspace",
        str(scanned.workspace.path),
        "--device",
        "cpu",
        "--out",
        str(tmp_path / "o"),
    ]
    result = CliRunner().invoke(app, ["predict", str(scans), *arguments, "--json"])
    assert result.exit_code == 1, result.output
    printed = json.loads(result.stdout)
    assert (printed["scans"], len(printed["skipped"])) == (outcome.data["scans"], 2)
    around = PredictScans(scans, tmp_path, scanned.workspace, FAMILY, **CPU).run(Recorder())
    assert around.data["scans"] == outcome.data["scans"], "into a folder around the scans"
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "near").write_text("a file")
    blocked = PredictScans(scans, tmp_path / "taken", scanned.workspace, FAMILY, **CPU).run(Recorder())
    assert [Path(document["scan"]).name for document in blocked.data["scans"]] == ["first.npz"]
    (line, *_) = [line for line in blocked.data["skipped"] if line.startswith("near/second.npy: ")]
    assert f"{tmp_path / 'taken' / 'near'} cannot be written" in line, "the message names the result, not the scan"
    empty = PredictScans(tmp_path / "alone", tmp_path / "none", scanned.workspace, FAMILY, **CPU)
    with pytest.raises(InputError, match=r"expected a scan, one of \.npz"):
        empty.plan()


def test_a_scan_whose_name_is_no_text_is_predicted_too(scanned: Scanned, tmp_path: Path) -> None:
    points = open_scans(next(scanned.scans("test"))).read("points", 0)
    (tmp_path / "scans").mkdir()
    with Path(os.fsdecode(os.fsencode(tmp_path / "scans") + b"/bad\xff.npz")).open("wb") as file:
        np.savez(file, points=points)
    found = PredictScans(tmp_path / "scans", tmp_path / "out", scanned.workspace, FAMILY, **CPU).run(Recorder())
    assert not found.failed
    assert len(list((tmp_path / "out").iterdir())) == 3
    (picture,) = (tmp_path / "out").glob("*.svg")
    assert picture.read_text(encoding="utf-8").startswith("<svg")


def test_results_of_a_folder_have_different_names_and_point_clouds_need_no_camera(scanned: Scanned, tmp_path: Path) -> None:
    points = open_scans(next(scanned.scans("test"))).read("points", 0)
    scans = tmp_path / "scans"
    scans.mkdir()
    np.savez(scans / "a.npz", points=points)
    np.save(scans / "a.npy", points)
    np.savez(scans / "a.npy.npz", points=points)
    camera = Intrinsics(300.0, 300.0, 159.5, 119.5)
    found = PredictScans(scans, tmp_path / "out", scanned.workspace, FAMILY, camera, **CPU).run(Recorder())
    assert found.failed == 0, found.data["skipped"]
    assert sorted(path.stem for path in (tmp_path / "out").glob("*.json")) == ["a.npy", "a.npy.npz", "a.npz"]


def test_networks_that_know_a_floor_give_its_points_to_no_part(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.prepared, tmp_path / "workspace" / "prepared")
    config = tmp_path / "floor.toml"
    config.write_text(Path(scanned.config).read_text(encoding="utf-8") + "[scans.sensor]\nfloor = true\n", encoding="utf-8")
    floored = Scanned(Workspace(tmp_path / "workspace"), str(config))
    floored.render(extra=()).run(Recorder())
    training = open_scan_dataset(floored.workspace, CATEGORY).files["train"]
    assert all((file.read("parts") == NO_PART).any() for file in training), "the floor is visible, and belongs to no part"
    floored.train("supervised").run(Recorder())
    weights = ScanRun(CATEGORY, "supervised", 0).weights(floored.workspace)
    assert weights is not None
    header = json.loads(weights[0].with_suffix(".json").read_text(encoding="utf-8"))
    known = json.loads(
        ScanRun(CATEGORY, "supervised", 0).folder(scanned.workspace, "ancsh").joinpath("weights.json").read_text()
    )
    assert header["facts"]["classes"] == known["facts"]["classes"] + 1
    example = ExampleScan(floored.workspace, FAMILY, tmp_path / "scan.npz", floored.render())
    example.run(Recorder())
    PredictScans(example.path, tmp_path / "out", floored.workspace, FAMILY, **CPU).run(Recorder())
    with np.load(tmp_path / "out" / "scan.parts.npz") as labelled:
        assert set(np.unique(labelled["parts"])) <= {NO_PART, 0, 1}


def test_the_command_reads_a_depth_image_in_millimetres(scanned: Scanned, tmp_path: Path) -> None:
    points = open_scans(next(scanned.scans("test"))).read("points", 0)
    depth = np.zeros((480, 640), np.uint16)
    columns, rows = np.round(points[:, :2] / points[:, 2:] * 500.0 + [320.0, 240.0]).astype(int).T
    depth[rows, columns] = np.round(1000.0 * points[:, 2])
    Image.fromarray(depth).save(tmp_path / "depth.png")
    camera = ["--intrinsics", "500,500,320,240", "--depth-scale", "1000"]
    where = ["--out", str(tmp_path / "out"), "--workspace", str(scanned.workspace.path), "--device", "cpu"]
    result = CliRunner().invoke(app, ["predict", str(tmp_path / "depth.png"), "--category", FAMILY, *camera, *where])
    assert result.exit_code == 0, result.output
    with np.load(tmp_path / "out" / "depth.parts.npz") as labelled:
        np.testing.assert_array_equal(labelled["places"], np.flatnonzero(depth))
        np.testing.assert_array_equal(np.round(1000.0 * labelled["points"][:, 2]), depth[depth > 0])
        assert np.abs(labelled["points"][:, None] - points[None]).max(axis=2).min(axis=1).max() < 0.01, "within a pixel"
    (joint,) = json.loads((tmp_path / "out" / "depth.json").read_text())["joints"]
    assert joint["kind"] == "R"


def test_only_earlier_results_for_the_same_scan_are_replaced(scanned: Scanned, tmp_path: Path) -> None:
    points = open_scans(next(scanned.scans("test"))).read("points", 0)
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        np.savez(tmp_path / folder / "seen.npz", points=points)
    stages = [
        PredictScans(tmp_path / folder / "seen.npz", tmp_path / "out", scanned.workspace, FAMILY, **CPU) for folder in "ab"
    ]
    stages[0].run(Recorder())
    stages[0].run(Recorder())
    (tmp_path / "elsewhere").symlink_to(tmp_path / "a")
    PredictScans(tmp_path / "elsewhere" / "seen.npz", tmp_path / "out", scanned.workspace, FAMILY, **CPU).plan()
    before = contents(tmp_path / "out")
    for attempt in (stages[1].plan, lambda: stages[1].run(Recorder())):
        with pytest.raises(InputError, match=r"seen\.json: exists, and is no prediction for this scan"):
            attempt()
    assert contents(tmp_path / "out") == before
    (tmp_path / "out" / "seen.json").unlink()
    with pytest.raises(InputError, match=r"seen\.svg: exists, and is no prediction for this scan"):
        stages[0].plan()


def test_results_go_into_a_folder(scanned: Scanned, tmp_path: Path) -> None:
    np.save(tmp_path / "scan.npy", np.random.default_rng(0).uniform(1.0, 2.0, (64, 3)))
    (tmp_path / "out").write_text("a file")
    for attempt in (lambda stage: stage.plan(), lambda stage: stage.run(Recorder())):
        with pytest.raises(InputError, match="out: expected a folder: this is a file"):
            attempt(PredictScans(tmp_path / "scan.npy", tmp_path / "out", scanned.workspace, FAMILY, **CPU))
        with pytest.raises(InputError, match=r"below: .*out is a file, not a folder"):
            attempt(PredictScans(tmp_path / "scan.npy", tmp_path / "out" / "below", scanned.workspace, FAMILY, **CPU))


def test_intrinsics_of_another_image_are_reported(scanned: Scanned, tmp_path: Path) -> None:
    np.save(tmp_path / "small.npy", np.random.default_rng(1).uniform(1.0, 2.0, (24, 32)))
    camera, observer = Intrinsics(525.0, 525.0, 319.5, 239.5), Recorder()
    PredictScans(tmp_path / "small.npy", tmp_path / "out", scanned.workspace, FAMILY, camera, **CPU).run(observer)
    assert [note for note in observer.notes if "the principal point (319.5, 239.5) is outside" in note]


def test_a_source_without_scans_is_reported_before_anything_runs(scanned: Scanned, tmp_path: Path) -> None:
    for name, problem in (("none.npz", "no such file"), (".", "expected a scan, one of")):
        with pytest.raises(InputError, match=problem):
            PredictScans(tmp_path / name, tmp_path / "out", scanned.workspace, FAMILY, **CPU).plan()


def test_a_category_without_networks_is_reported_with_those_that_have_some(scanned: Scanned, tmp_path: Path) -> None:
    for name, problem in (
        ("plyers", r"no networks for scans of plyers \(did you mean Pliers\?\); there are networks for Pliers$"),
        (
            "oil rig",
            r"no networks for scans of oil rig; there are networks for Pliers: .* --category 'oil rig' first",
        ),
    ):
        with pytest.raises(InputError, match=problem):
            PredictScans(tmp_path / "x.npz", tmp_path, scanned.workspace, name).run(Recorder())
    with pytest.raises(
        InputError, match=r"no networks for scans of pliers that learned from pseudo labels of kinmo: .* --method kinmo first"
    ):
        PredictScans(tmp_path / "x.npz", tmp_path, scanned.workspace, FAMILY, method="kinmo").run(Recorder())
    with pytest.raises(InputError, match="run kinmo render first"):
        TrainScans(scanned.workspace, scanned.config, "safe").run(Recorder())


def test_points_of_a_ply_file_are_those_of_an_array(scanned: Scanned, tmp_path: Path) -> None:
    points = open_scans(next(scanned.scans("test"))).read("points", 0)
    np.savez(tmp_path / "seen.npz", points=points)
    trimesh.PointCloud(points).export(tmp_path / "seen.ply")
    documents = []
    for name in ("seen.npz", "seen.ply"):
        where = ["--out", str(tmp_path / name[-3:]), "--workspace", str(scanned.workspace.path), "--device", "cpu"]
        result = CliRunner().invoke(app, ["predict", str(tmp_path / name), "--category", FAMILY, *where])
        assert result.exit_code == 0, result.output
        documents.append(json.loads((tmp_path / name[-3:] / "seen.json").read_text()))
        assert documents[-1].pop("scan") == str((tmp_path / name).resolve())
    assert documents[0] == documents[1]
