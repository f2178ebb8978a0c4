"""The folder of a result: written as a whole, and read back with the shape as it was predicted."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from cabinet_results import cabinet_prediction, predict_cabinets
from predicted_cabinet import PIECES, write_cabinet_glb

from kinmo.core.errors import InputError
from kinmo.core.shape_digest import shape_digest
from kinmo.io.readers.stated_facts import StatedFacts
from kinmo.io.result_folder import files_below, read_result, write_result
from kinmo.io.writers import WRITERS, ExportOptions
from kinmo.io.writers.joints_json_writer import joints_document
from kinmo.robot.physics import Physics

FORMATS = ("urdf", "joints_json")


def write(folder: Path, formats: tuple[str, ...] = FORMATS, **how: Any) -> Path:
    """A result for the cabinet in `folder`/out."""
    prediction = cabinet_prediction(folder)
    options = ExportOptions("out", 1.0, provenance=prediction.provenance)
    write_result(prediction.shape, prediction.estimate, folder / "out", formats, options, **how)
    return folder / "out"


def test_what_is_written_is_read_back(tmp_path: Path) -> None:
    folder = write(tmp_path)
    saved = read_result(folder)
    assert saved.options.formats == FORMATS
    document = joints_document(saved.shape, saved.estimate, saved.options)
    assert json.loads(json.dumps(document)) == json.loads((folder / "joints.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    "physics", [Physics(), Physics(density=600.0), Physics(part_densities={"door": 9.0}), Physics(friction=0.0, velocity=2.0)]
)
def test_the_physics_of_an_export_is_kept(tmp_path: Path, physics: Physics) -> None:
    prediction = cabinet_prediction(tmp_path)
    prediction.export(tmp_path / "out", FORMATS, collision="none", physics=physics)
    document = json.loads((tmp_path / "out" / "joints.json").read_text(encoding="utf-8"))
    assert ("physics" in document["export"]) == (physics != Physics())
    assert read_result(tmp_path / "out").options.physics == physics


@pytest.mark.parametrize(
    "facts", [StatedFacts(up="z", front="-y"), StatedFacts(up="-x"), StatedFacts("chair", metres_per_unit=0.01)], ids=str
)
def test_stated_facts_are_kept(tmp_path: Path, facts: StatedFacts) -> None:
    predict_cabinets(write_cabinet_glb(tmp_path / "cabinet.glb"), tmp_path / "out", facts)
    found, expected = read_result(tmp_path / "out" / "cabinet").shape, facts.of(cabinet_prediction(tmp_path).shape)
    for name in ("id", "category", "up", "front", "metres_per_unit", "guesses"):
        assert getattr(found, name) == getattr(expected, name)
    assert shape_digest(found) == shape_digest(expected)


def labelled_mesh(folder: Path) -> StatedFacts:
    """The cabinet as one mesh in cabinet.glb, and a file with the part of every triangle."""
    boxes = [
        trimesh.creation.box(extents, trimesh.transformations.translation_matrix(center)) for center, extents in PIECES.values()
    ]
    trimesh.util.concatenate(boxes).export(folder / "cabinet.glb")
    np.save(folder / "faces.npy", np.repeat(np.arange(len(boxes)), 12))
    return StatedFacts(labels=folder / "faces.npy")


def test_parts_by_labels_are_read_again(tmp_path: Path) -> None:
    facts = labelled_mesh(tmp_path)
    assert predict_cabinets(tmp_path / "cabinet.glb", tmp_path / "out", facts).failed == 0
    assert len(read_result(tmp_path / "out" / "cabinet").shape.leaves) == len(PIECES)
    np.save(tmp_path / "faces.npy", np.arange(12 * len(PIECES)) % 3)
    with pytest.raises(InputError, match=r"cabinet\.glb: it or its labels .*faces\.npy changed since the prediction"):
        read_result(tmp_path / "out" / "cabinet")
    (tmp_path / "faces.npy").unlink()
    with pytest.raises(InputError, match=r"faces\.npy: missing: put the labels of the parts back, or run kinmo predict again"):
        read_result(tmp_path / "out" / "cabinet")


def test_a_floor_is_dropped_again_where_up_was_stated(tmp_path: Path) -> None:
    scene = trimesh.load_scene(write_cabinet_glb(tmp_path / "cabinet.glb"))
    wall = trimesh.creation.box((9.0, 9.0, 0.01), trimesh.transformations.translation_matrix((0.0, 0.5, -0.3)))
    scene.add_geometry(wall, node_name="wall", geom_name="wall")
    scene.export(tmp_path / "cabinet.glb")
    predict_cabinets(tmp_path / "cabinet.glb", tmp_path / "out", StatedFacts(up="z"))
    assert len(read_result(tmp_path / "out" / "cabinet").shape.leaves) == len(PIECES)


def test_a_changed_or_missing_source_is_one_line_with_the_remedy(tmp_path: Path) -> None:
    folder = write(tmp_path)
    source = (tmp_path / "cabinet.glb").rename(tmp_path / "moved.glb")
    with pytest.raises(InputError, match=r"cabinet\.glb: missing: name the file of the shape by --source$"):
        read_result(folder)
    assert read_result(folder, source).shape.source == source
    write_cabinet_glb(source, ("frame", "door", "handle", "front", "box"))
    with pytest.raises(InputError, match=r"moved\.glb: has changed since .*: run kinmo predict again, which keeps overrides"):
        read_result(folder, source)
    with pytest.raises(InputError, match=r"nowhere: no such file or folder"):
        read_result(folder, tmp_path / "nowhere")


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        (("export", "metres_per_unit"), 0, r"export\.metres_per_unit: expected a positive number"),
        (("export", "name"), "../../cabinet", r"export\.name: expected a file name without folders"),
        (("export", "physics"), 600, r"export\.physics: expected an object"),
        (("export", "physics"), {"density": 0}, r"export\.physics\.density: expected a positive number, got 0"),
        (("export", "physics"), {"friction": "a"}, r"export\.physics\.friction: expected a number"),
        (("export", "physics"), {"damping": -1.0}, r"export\.physics\.damping: expected a finite number of at least 0, got -1"),
        (("export", "physics"), {"part_densities": [1]}, r"export\.physics\.part_densities: expected an object"),
        (("export", "physics"), {"part_densities": {"a": "b"}}, r"export\.physics\.part_densities\.a: expected a number"),
        (("export", "physics"), {"part_densities": {"a": -1}}, r"export\.physics\.part_densities\.a: expected a positive"),
        (("shape", "layout"), "lego", r"shape\.layout: expected one of "),
        (("shape", "up"), [0, 1], r"shape\.up: expected 3 numbers"),
        (("shape", "labels"), 3, r"shape\.labels: expected a text"),
        (("bodies",), [], r"bodies: expected every leaf of the shape in one body: run kinmo predict again"),
        (("schema_version",), 99, r"schema_version: expected 1"),
    ],
)
def test_a_wrong_field_is_named(tmp_path: Path, field: tuple[str, ...], value: object, message: str) -> None:
    file = write(tmp_path) / "joints.json"
    document = json.loads(file.read_text(encoding="utf-8"))
    inner = document
    for key in field[:-1]:
        inner = inner[key]
    inner[field[-1]] = value
    file.write_text(json.dumps(document), encoding="utf-8")
    with pytest.raises(InputError, match=message) as caught:
        read_result(file.parent)
    assert str(caught.value).startswith(f"{file}: ") and "\n" not in str(caught.value)


def test_the_folder_is_replaced_but_for_what_is_kept(tmp_path: Path) -> None:
    folder = write(tmp_path)
    (folder / "overrides.toml").write_text("# mine\n", encoding="utf-8")
    (folder / "notes").mkdir()
    (folder / "notes" / "a.txt").write_text("a", encoding="utf-8")
    (folder / "notes" / "link").symlink_to("a.txt")
    write(tmp_path, kept=("overrides.toml", "notes/a.txt", "notes/link", "gone.txt"))
    assert (folder / "notes" / "a.txt").read_text(encoding="utf-8") == "a" and (folder / "notes" / "link").is_symlink()
    write(tmp_path, ("joints_json",))
    assert sorted(files_below(folder)) == ["joints.json", "overrides.toml"]
    assert (folder / "overrides.toml").read_text(encoding="utf-8") == "# mine\n"


def test_a_failed_export_leaves_the_folder_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = write(tmp_path)
    before = {name: (folder / name).read_bytes() for name in files_below(folder)}

    def full(exported: Any, draft: Path) -> Path:
        (draft / "half").touch()
        raise OSError(28, os.strerror(28))

    monkeypatch.setitem(WRITERS, "urdf", full)
    with pytest.raises(OSError):
        write(tmp_path)
    assert {name: (folder / name).read_bytes() for name in files_below(folder)} == before
    assert {path.name for path in tmp_path.iterdir()} == {"cabinet.glb", "out"}
    with pytest.raises(InputError, match="unknown format lego"):
        write(tmp_path, ("joints_json", "lego"))


def test_a_link_to_the_folder_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "out").symlink_to(tmp_path / "elsewhere")
    assert write(tmp_path).is_symlink() and (tmp_path / "elsewhere" / "joints.json").is_file()
