"""Prediction of users' shapes: folders and their names, guesses, and problems with single shapes."""

from __future__ import annotations

import json
import os
import re
import shutil
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from datasets import write_partnet, write_partnet_mobility
from rigid_method import RigidMethod, source_of
from trained_workspace import METHODS, Recorder, Trained, contents

import kinmo
from kinmo import _core
from kinmo.core.errors import InputError
from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body, Mobility
from kinmo.core.motion_types import MotionType
from kinmo.core.names import MAX_NAME_BYTES
from kinmo.core.shape_estimate import JointEstimate, ShapeEstimate
from kinmo.features.prepared_shape import PreparedShape
from kinmo.features.shape_preparation import prepare_shape
from kinmo.io.readers import read_partnet
from kinmo.io.readers.joints_json_reader import read_joints_json
from kinmo.io.readers.stated_facts import StatedFacts
from kinmo.io.writers import WRITERS, ExportedObject
from kinmo.io.writers.urdf_writer import write_urdf
from kinmo.pipeline import predict_shapes
from kinmo.pipeline.predict_shapes import PredictShapes

SHELF, DOOR = "棚", "扉"
"""Names of three bytes each."""
Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Rotation from y up and the front at +z to z up and the front at -y."""


def size_of_robot(urdf: Path) -> float:
    """Diagonal of the box around all links of a URDF at rest, in metres."""
    return kinmo.load(urdf).diagonal


def test_names_too_long_for_a_folder_are_cut_and_stay_unique(stage: PredictShapes) -> None:
    (source,) = stage.sources
    deep = source / (SHELF * 80) / (SHELF * 80) / (SHELF * 80)
    for place in (deep / DOOR / "scene", deep / f"{DOOR}{DOOR}" / "scene", source / (DOOR * 84), source / "door"):
        write_partnet(place)
    outcome = stage.run(Recorder())
    assert outcome.data["skipped"] == []
    folders = [Path(shape["folder"]) for shape in outcome.data["shapes"]]
    assert {path.name for path in stage.out.iterdir() if not path.name.startswith(".")} == {folder.name for folder in folders}
    assert sorted(folder.name.split("~")[0] for folder in folders) == ["door", DOOR * 50, SHELF * 50, SHELF * 50]
    assert all((folder / f"{folder.name}.urdf").is_file() for folder in folders)
    assert stage.plan().steps == (), "it is done"


def test_folders_that_cannot_be_searched_are_named(stage: PredictShapes) -> None:
    write_partnet(stage.sources[0] / "door")
    (stage.sources[0] / Path(*["deep"] * 70)).mkdir(parents=True)
    recorder = Recorder()
    outcome = stage.run(recorder)
    assert outcome.failed == len(outcome.data["skipped"]) == 1
    assert [note for note in recorder.notes if note == f"skipped: {outcome.data['skipped'][0]}"]


@pytest.mark.parametrize("name", ["d" * MAX_NAME_BYTES, DOOR * (MAX_NAME_BYTES // 3), "Tür"])
def test_names_that_fit_stay_as_they_are(stage: PredictShapes, name: str) -> None:
    write_partnet(stage.sources[0] / name)
    assert [Path(shape["folder"]).name for shape in stage.run(Recorder()).data["shapes"]] == [name]


def test_a_result_that_cannot_be_written_stops_no_other_shape(stage: PredictShapes, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(exported: ExportedObject, folder: Path) -> Path:
        if exported.shape.id == "b":
            raise OSError(28, os.strerror(28), str(folder / "b.urdf"))
        return write_urdf(exported, folder)

    monkeypatch.setitem(WRITERS, "urdf", full)
    for name in "abc":
        write_partnet(stage.sources[0] / name)
    recorder = Recorder()
    outcome = stage.run(recorder)
    assert [shape["id"] for shape in outcome.data["shapes"]] == ["a", "c"]
    (line,) = outcome.data["skipped"]
    assert line.startswith(f"{stage.sources[0] / 'b'}: ") and "b.urdf: No space left on device" in line
    assert recorder.notes == ["networks: none", f"skipped: {line}"] and outcome.failed == 1
    assert not (stage.out / "b").exists()


def test_an_unforeseen_error_stops_no_other_shape(stage: PredictShapes, monkeypatch: pytest.MonkeyPatch) -> None:
    def unforeseen(shape: Any, **how: Any) -> PreparedShape:
        if shape.id == "b":
            raise RuntimeError("no such axis")
        return prepare_shape(shape, **how)

    monkeypatch.setattr(predict_shapes, "prepare_shape", unforeseen)
    for name in "abc":
        write_partnet(stage.sources[0] / name)
    outcome = stage.run(Recorder())
    assert [shape["id"] for shape in outcome.data["shapes"]] == ["a", "c"]
    (line,) = outcome.data["skipped"]
    assert line.startswith(f"{stage.sources[0] / 'b'}: cannot be predicted: RuntimeError at test_predict_shapes.py:")
    assert line.endswith(": no such axis") and outcome.failed == 1


def test_an_annotated_shape_keeps_an_id_that_several_shapes_have(stage: PredictShapes) -> None:
    write_partnet_mobility(stage.sources[0] / "dataset" / "7")
    write_partnet(stage.sources[0] / "data_v0" / "7")
    stage.run(Recorder())
    names = {path.name for path in stage.out.iterdir() if path.is_dir()}
    assert names == {"7", "data_v0__7"}
    assert source_of(stage.out / "7") == str(stage.sources[0] / "dataset" / "7")
    write_partnet_mobility(stage.sources[0] / "again" / "7")
    found = replace(stage, out=stage.out.with_name("other")).run(Recorder())
    assert {Path(shape["folder"]).name for shape in found.data["shapes"]} == {"again__7", "data_v0__7", "dataset__7"}


def test_a_folder_with_scans_alone_is_refused(stage: PredictShapes) -> None:
    stage.sources[0].mkdir()
    for name in ("a.npz", "b.ply", "notes.txt"):
        (stage.sources[0] / name).touch()
    for call in (stage.plan, lambda: stage.run(Recorder())):
        with pytest.raises(
            InputError, match=r"at least one shape at or below it .*\. Found 2 scans: for scans, add --category"
        ):
            call()


def test_an_empty_folder_is_refused_in_a_dry_run_too(stage: PredictShapes) -> None:
    stage.sources[0].mkdir()
    for call in (stage.plan, lambda: stage.run(Recorder())):
        with pytest.raises(InputError, match="expected at least one shape at or below it"):
            call()
    assert not stage.out.exists()


def test_a_bad_shape_stops_no_other(trained: Trained, tmp_path: Path) -> None:
    source, out = tmp_path / "mine", tmp_path / "out"
    some = sorted((trained.shapes / "partnet").iterdir())[:2]
    for folder in some:
        shutil.copytree(folder, source / folder.name)
    (source / some[0].name / "result.json").write_text("[{", encoding="utf-8")
    stage = PredictShapes([source], out, trained.workspace, METHODS[0], device="cpu")
    assert stage.run(Recorder()).failed == 1
    assert [path.parent.name for path in out.glob("*/joints.json")] == [some[1].name]
    assert (out / some[1].name / f"{some[1].name}.urdf").exists()
    before = contents(out)
    assert stage.run(Recorder()).failed == 1
    assert contents(out) == before


def test_repairs_of_a_shape_are_noted(trained: Trained, tmp_path: Path) -> None:
    source = sorted((trained.shapes / "partnet").iterdir())[0]
    shutil.copytree(source, tmp_path / "shapes" / source.name)
    nodes = json.loads((source / "result.json").read_text())
    while nodes[0].get("children"):
        nodes = nodes[0]["children"]
    for name in nodes[0]["objs"]:
        (tmp_path / "shapes" / source.name / "objs" / f"{name}.obj").write_text("", encoding="utf-8")
    recorder = Recorder()
    found = PredictShapes([tmp_path / "shapes"], tmp_path / "out", trained.workspace, METHODS[0], device="cpu").run(recorder)
    (shape,) = found.data["shapes"]
    assert any("no surface" in repair for repair in shape["repairs"])
    assert recorder.notes[1:] == [f"repaired: {shape['id']}: {'; '.join(shape['repairs'])}"]
    assert "1 repaired, 0 skipped" in found.text


def test_a_shape_with_z_up_gets_the_joints_of_its_copy_with_y_up(trained: Trained, tmp_path: Path) -> None:
    source = sorted((trained.shapes / "partnet").iterdir())[0]
    standing, lying = tmp_path / "y" / source.name, tmp_path / "z" / source.name
    for copy in (standing, lying):
        shutil.copytree(source, copy)
    for path in (lying / "objs").glob("*.obj"):
        text = re.sub(r"^v (\S+) (\S+) (\S+)", with_z_up, path.read_text(encoding="utf-8"), flags=re.M)
        path.write_text(text, encoding="utf-8")
    predict = PredictShapes([standing], tmp_path / "out y", trained.workspace, METHODS[0], device="cpu")
    predict.run(Recorder())
    replace(predict, sources=[lying], out=tmp_path / "out z", facts=StatedFacts(up="z")).run(Recorder())
    wanted, found = (
        read_joints_json(tmp_path / f"out {up}" / source.name / "joints.json", read_partnet(folder))[0]
        for up, folder in (("y", standing), ("z", lying))
    )
    assert len(found.mobility.bodies) == len(wanted.mobility.bodies)
    for body, expected in zip(found.mobility.bodies, wanted.mobility.bodies, strict=True):
        assert body.leaves == expected.leaves and (body.joint is None) == (expected.joint is None)
        if body.joint is not None and expected.joint is not None:
            assert body.joint.direction == pytest.approx(Z_UP @ expected.joint.direction, abs=1e-9)
            assert body.joint.pivot == pytest.approx(Z_UP @ expected.joint.pivot, abs=1e-9)
            assert (body.joint.lower, body.joint.upper) == pytest.approx((expected.joint.lower, expected.joint.upper))
    assert any(body.joint is not None for body in wanted.mobility.bodies)
    shape = json.loads((tmp_path / "out z" / source.name / "joints.json").read_text(encoding="utf-8"))["shape"]
    assert shape["up"] == [0.0, 0.0, 1.0]
    assert shape["center"] == pytest.approx(Z_UP @ read_partnet(standing).center)


def with_z_up(vertex: re.Match[str]) -> str:
    """A vertex line of an OBJ file, rotated by `Z_UP`."""
    x, y, z = vertex.groups()
    return f"v {x} {-float(z)!r} {y}"


def test_shapes_of_the_same_name_go_into_folders_named_by_their_paths(trained: Trained, tmp_path: Path) -> None:
    some = sorted((trained.shapes / "partnet").iterdir())[:2]
    for place, shape in zip(("kitchen", "lab"), some, strict=True):
        shutil.copytree(shape, tmp_path / "shapes" / place / "scene")
    stage = PredictShapes(
        [tmp_path / "shapes"],
        tmp_path / "out",
        trained.workspace,
        METHODS[0],
        device="cpu",
        facts=StatedFacts(metres_per_unit=100.0),
    )
    assert stage.plan().steps == (f"predict 2 shapes into {tmp_path / 'out'}",)
    recorder = Recorder()
    found = stage.run(recorder)
    assert [Path(shape["folder"]).name for shape in found.data["shapes"]] == ["kitchen__scene", "lab__scene"]
    titles = [line.split()[0] for line in found.text.splitlines() if "(category" in line]
    assert titles == ["kitchen__scene", "lab__scene"]
    for place, shape in zip(("kitchen", "lab"), found.data["shapes"], strict=True):
        assert shape["id"] == "scene" and shape["source"] == str(tmp_path / "shapes" / place / "scene")
        assert source_of(Path(shape["folder"])) == shape["source"]
        size = 100.0 * shape["diagonal"]
        assert f"{place}__scene: {size:.0f} m across: set --metres-per-unit if the file is not in metres" in recorder.notes
        assert size_of_robot(Path(shape["urdf"])) == pytest.approx(size, rel=1e-6)
    assert stage.plan().steps == (), "it is done"
    for call in (replace(stage, out=tmp_path / "shapes").plan, lambda: replace(stage, out=tmp_path / "shapes").run(Recorder())):
        with pytest.raises(InputError, match="--out: is the folder with the shapes"):
            call()


@dataclass(frozen=True)
class HingeMethod(RigidMethod):
    """A method that predicts a hinge for the last leaf."""

    score: float = 0.85

    def predict(self, shape: PreparedShape, meshes: _core.Meshes) -> ShapeEstimate:
        hinge = Joint(JointKind.REVOLUTE, np.array([0.0, 1.0, 0.0]), np.zeros(3), lower=0.0, upper=np.pi / 2)
        bodies = (Body(0, "base", shape.leaves[:-1]), Body(1, "door", shape.leaves[-1:], 0, hinge))
        still, moves = JointEstimate(None, MotionType.NONE, 1.0), JointEstimate(hinge, MotionType.R_V_S, self.score)
        return ShapeEstimate(shape.id, "Cabinet", Mobility(bodies), ((still,), (moves,)), (still, moves), self.name)


@pytest.mark.parametrize(("score", "words"), [(0.85, "score 0.85"), (0.2, "score 0.20, uncertain")])
def test_the_terminal_shows_every_joint_and_its_score(
    stage: PredictShapes, monkeypatch: pytest.MonkeyPatch, score: float, words: str
) -> None:
    monkeypatch.setattr(predict_shapes, "load_trained_or_shipped", lambda *_: HingeMethod(score=score))
    write_partnet(stage.sources[0] / "cabinet")
    lines = stage.run(Recorder()).text.splitlines()
    assert lines == ["cabinet (category Cabinet)", f"  door: hinge, 0 to 90°, {words}", "1 shape, 1 joint, 0 skipped"]


def test_many_shapes_are_totals_and_the_place_of_their_joints(stage: PredictShapes, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(predict_shapes, "MAX_LISTED_SHAPES", 1)
    for name in ("bed", "desk"):
        write_partnet(stage.sources[0] / name)
    lines = stage.run(Recorder()).text.splitlines()
    assert lines == ["2 shapes, 0 joints, 0 skipped", f"each joint with its score: {stage.out}/*/joints.json"]


@pytest.mark.parametrize(
    ("category", "note"),
    [
        ("Refrigarator", ["--category Refrigarator is new to kinmo (did you mean Refrigerator?)"]),
        ("storage_furnitur", ["--category storage_furnitur is new to kinmo (did you mean StorageFurniture?)"]),
        ("Tresor", ["--category Tresor is new to kinmo"]),
        ("door_set", []),
    ],
)
def test_a_category_that_is_new_is_noted(stage: PredictShapes, category: str, note: list[str]) -> None:
    write_partnet(stage.sources[0] / "door")
    recorder = Recorder()
    replace(stage, facts=StatedFacts(category=category)).run(recorder)
    assert [line for line in recorder.notes if line.startswith("--category")] == note


def test_an_empty_file_is_named_and_leaves_no_path(stage: PredictShapes) -> None:
    stage.sources[0].mkdir()
    (stage.sources[0] / "cabinet.glb").touch()
    outcome = stage.run(Recorder())
    assert outcome.data["skipped"] == [f"{stage.sources[0] / 'cabinet.glb'}: is empty: write it again"]
    assert outcome.path is None


def test_a_mesh_in_one_piece_is_an_error_that_says_how_to_get_parts(stage: PredictShapes) -> None:
    path = stage.sources[0].with_suffix(".glb")
    trimesh.creation.icosphere().export(path)
    outcome = replace(stage, sources=[path]).run(Recorder())
    (line,) = outcome.data["skipped"]
    assert outcome.failed == 1
    assert line.startswith(f"{path}: is one closed mesh, so no parts can be told apart: separate the object into")
    assert "--labels faces.npy" in line


def boxes_file(path: Path, *shifts: tuple[float, float, float], scale: float = 1.0) -> Path:
    """A file with a mesh of boxes."""
    boxes = [trimesh.creation.box((1.0, 2.0, 0.5)).apply_translation(shift).apply_scale(scale) for shift in shifts]
    path.parent.mkdir(parents=True, exist_ok=True)
    trimesh.util.concatenate(boxes).export(path)
    return path


def test_guesses_are_printed_and_written(stage: PredictShapes) -> None:
    path = boxes_file(stage.sources[0] / "a.glb", (0, 0, 0), (3, 0, 0))
    recorder = Recorder()
    replace(stage, sources=[path]).run(recorder)
    options = "(if wrong: --up, --metres-per-unit, --category)"
    assert f"guessed: up +y (glTF), 1 unit = 1 m, category unknown {options}" in recorder.notes
    shape = json.loads((stage.out / "a" / "joints.json").read_text(encoding="utf-8"))["shape"]
    assert shape["guessed"] == {"up": "up +y (glTF)", "metres_per_unit": "1 unit = 1 m", "category": "category unknown"}
    assert (shape["front"], shape["metres_per_unit"], shape["category"]) == ([0.0, 0.0, 1.0], 1.0, "")


def test_equal_guesses_about_several_shapes_are_one_line(stage: PredictShapes) -> None:
    for name in "abc":
        boxes_file(stage.sources[0] / name / "scene.glb", (0, 0, 0), (3, 0, 0))
    recorder = Recorder()
    stage.run(recorder)
    lines = [line for line in recorder.notes if line.startswith("guessed")]
    options = "(if wrong: --up, --metres-per-unit, --category)"
    assert lines == [f"guessed for 3 shapes, such as a__scene: up +y (glTF), 1 unit = 1 m, category unknown {options}"]


def test_what_is_stated_is_not_guessed(stage: PredictShapes) -> None:
    path = boxes_file(stage.sources[0] / "a.stl", (0, 0, 0), (3, 0, 0), scale=1000.0)
    recorder = Recorder()
    facts = StatedFacts("storage furniture", "y", "x", 0.01)
    replace(stage, sources=[path], facts=facts).run(recorder)
    shape = json.loads((stage.out / "a" / "joints.json").read_text(encoding="utf-8"))["shape"]
    assert not [line for line in recorder.notes if line.startswith("guessed")]
    assert (shape["guessed"], shape["category"], shape["up"]) == ({}, "StorageFurniture", [0.0, 1.0, 0.0])
    assert (shape["front"], shape["metres_per_unit"]) == ([1.0, 0.0, 0.0], 0.01)
    assert size_of_robot(stage.out / "a" / "a.urdf") == pytest.approx(0.01 * shape["diagonal"], rel=1e-6)


def test_other_labels_make_another_prediction(stage: PredictShapes, tmp_path: Path) -> None:
    path = boxes_file(stage.sources[0] / "a.glb", (0, 0, 0), (3, 0, 0), (6, 0, 0))
    predict = replace(stage, sources=[path], facts=StatedFacts(labels=tmp_path / "faces.npy"))
    for parts in (2, 3):
        np.save(tmp_path / "faces.npy", np.arange(36) % parts)
        assert predict.plan().steps
        assert predict.run(Recorder()).data["shapes"][0]["parts"] == parts
    assert predict.plan().steps == ()
    np.save(tmp_path / "faces.npy", np.arange(35))
    (line,) = predict.run(Recorder()).data["skipped"]
    assert "expected 36 integers, one per triangle of a.glb" in line
