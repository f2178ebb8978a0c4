"""Scoring of URDF files: exact figures for known errors, and a reason for every failure."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from articulated import shape_of_boxes
from exports import write_partnet_mobility, write_urdf
from scipy.spatial.transform import Rotation
from trained_workspace import Recorder

from kinmo.core.errors import InputError
from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body, Mobility
from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.tables import WRITERS, Caption, as_text, read_table
from kinmo.evaluation.urdf_scoring import (
    find_urdf,
    score_urdf,
    score_urdf_folder,
    summarise_urdf_scores,
    urdf_failures_table,
    urdf_table,
)
from kinmo.evaluation.urdf_scoring import urdf_scores as scoring
from kinmo.evaluation.urdf_scoring.frame_alignment import align_surfaces, axis_rotations
from kinmo.evaluation.urdf_scoring.sampled_surface import Surface
from kinmo.io.readers.partnet_annotation import PSEUDO_LABEL
from kinmo.io.writers import ExportOptions
from kinmo.pipeline.score_urdfs import ScoreUrdfs

UP = np.array([0.0, 1, 0])
BOXES = [
    ((0, 0, 0), (1, 2, 0.8)),
    ((0, 0.9, 0.8), (0.9, 2, 0.86)),
    ((0.05, 0.1, 0.3), (0.9, 0.7, 0.95)),
    ((0.3, 2.0, 0.3), (0.5, 2.2, 0.5)),
]
DOOR = Joint(JointKind.REVOLUTE, UP, np.array([0.0, 0, 0.8]), 0.0, 1.5)
DRAWER = Joint(JointKind.PRISMATIC, np.array([0.0, 0, 1]), np.zeros(3), 0.0, 0.4)
VALVE = Joint(JointKind.SCREW, UP, np.array([0.4, 2.0, 0.4]), 0.0, 0.1)
BODIES = (
    Body(0, "body", (1,)),
    Body(1, "door", (2,), 0, DOOR),
    Body(2, "drawer", (3,), 0, DRAWER),
    Body(3, "valve", (4,), 0, VALVE),
)
TRUTH = shape_of_boxes(BOXES, BODIES)


def with_joint(body, joint):
    return Mobility(tuple(replace(b, joint=joint) if i == body else b for i, b in enumerate(BODIES)))


def scored(tmp_path, mobility=TRUTH.mobility, truth=TRUTH, **options):
    return score_urdf(truth, write_urdf(TRUTH, mobility, tmp_path / "7", ExportOptions(**options)), tmp_path)


def part(score, name):
    return next(part for part in score.parts if part.name == name)


@pytest.mark.parametrize("scale", [1.0, 0.37, 25.0])
def test_the_truth_has_no_errors_in_any_unit(tmp_path, scale):
    score = scored(tmp_path, metres_per_unit=scale)
    assert (score.status, score.false_alarms) == ("scored", 0)
    assert score.residual < 1e-4
    for found in score.parts:
        assert found.kind_ok
        assert found.is_ok
        assert found.parent_ok
        assert found.is_relative
        assert found.limited_ok
        assert found.angle == pytest.approx(0, abs=1e-9)
        assert found.range_iou == pytest.approx(1)
        assert found.line == (None if found.name == "drawer" else pytest.approx(0, abs=1e-9))


def test_a_rotated_axis_and_a_shifted_pivot_are_measured(tmp_path):
    turned = replace(DOOR, direction=Rotation.from_rotvec([0, 0, math.radians(7)]).apply(UP))
    door = part(scored(tmp_path / "a", with_joint(1, turned)), "door")
    assert math.degrees(door.angle) == pytest.approx(7)
    assert not door.is_ok
    shifted = replace(DOOR, pivot=DOOR.pivot + 0.03 * TRUTH.diagonal * np.array([1.0, 0, 0]))
    door = part(scored(tmp_path / "b", with_joint(1, shifted)), "door")
    assert door.line == pytest.approx(0.03)
    assert door.is_ok
    assert door.line_at_part == pytest.approx(0.03)


def test_a_reversed_axis_with_its_range_is_the_same_joint(tmp_path):
    door = part(scored(tmp_path, with_joint(1, DOOR.reversed())), "door")
    assert door.range_iou == pytest.approx(1)


def test_a_missing_joint_and_an_extra_joint_are_counted(tmp_path):
    glued = Mobility((replace(BODIES[0], leaves=(1, 3)), BODIES[1], replace(BODIES[3], id=2)))
    score = scored(tmp_path / "a", glued)
    assert {p.name: p.found for p in score.parts} == {"door": True, "drawer": False, "valve": True}
    still = shape_of_boxes(BOXES, (replace(BODIES[0], leaves=(1, 3)), BODIES[1], replace(BODIES[3], id=2)))
    assert scored(tmp_path / "b", truth=still).false_alarms == 1


def test_a_joint_of_the_wrong_kind_is_found_but_not_right(tmp_path):
    door = part(scored(tmp_path, with_joint(1, replace(DOOR, kind=JointKind.PRISMATIC))), "door")
    assert door.found
    assert not door.kind_ok
    assert door.angle is None


def test_a_wrong_parent_is_not_ok(tmp_path):
    bodies = (*BODIES[:3], replace(BODIES[3], parent=1))
    assert not part(scored(tmp_path, Mobility(bodies)), "valve").parent_ok


def test_junk_may_be_kept_or_dropped(tmp_path):
    bodies = (*BODIES[:3], Body(3, "dust", (4,)))
    truth = replace(TRUTH, mobility=Mobility(bodies, frozenset({4})))
    kept = scored(tmp_path / "a", Mobility((replace(BODIES[0], leaves=(1, 4)), *BODIES[1:3])), truth)
    lean = shape_of_boxes(BOXES[:3], BODIES[:3])
    dropped = score_urdf(truth, write_urdf(lean, lean.mobility, tmp_path / "b"), tmp_path)
    for score in (kept, dropped):
        assert score.status == "scored"
        assert all(found.kind_ok for found in score.parts)
        assert score.false_alarms == 0


def test_all_joints_of_a_misaligned_shape_are_missed(tmp_path):
    boxes = [((0, 0, 0), (1, 1, 1)), ((3, 0, 0), (4, 1, 1))]
    other = shape_of_boxes(boxes, (Body(0, "a", (1,)), Body(1, "b", (2,), 0, DRAWER)))
    score = score_urdf(TRUTH, write_urdf(other, other.mobility, tmp_path / "7"), tmp_path)
    assert score.status == "failed"
    assert "misaligned" in score.reason
    assert not any(found.found for found in score.parts)


def test_alignment_finds_each_of_the_24_axis_rotations():
    rotations = axis_rotations()
    assert len(rotations) == 24
    rng = np.random.default_rng(0)
    triangles = np.concatenate([mesh.triangles for mesh in TRUTH.meshes()])
    truth = Surface(triangles, 3000, rng)
    for rotation in rotations[::5]:
        moved = (triangles @ rotation - [3, 2, 1]) * 0.5
        found = align_surfaces(truth, truth, Surface(moved, 3000, rng))
        assert found.apply(moved.reshape(-1, 3)) == pytest.approx(triangles.reshape(-1, 3), abs=1e-3)


def test_distances_to_a_surface_agree_with_an_exact_query():
    rng = np.random.default_rng(0)
    mesh = trimesh.creation.icosphere(subdivisions=2)
    queries = rng.normal(size=(200, 3))
    distances, feet = Surface(np.array(mesh.triangles), 4000, rng).nearest(queries)
    exact = trimesh.triangles.closest_point(np.repeat(mesh.triangles, 200, 0), np.tile(queries, (len(mesh.faces), 1)))
    best = np.linalg.norm(exact.reshape(-1, 200, 3) - queries, axis=2).min(axis=0)
    assert distances == pytest.approx(best, abs=1e-3)
    assert np.linalg.norm(feet - queries, axis=1) == pytest.approx(distances)


def folders(tmp_path):
    """Four shapes with predictions: a right one, a wrong one, a broken file, and none."""
    truth, predictions = tmp_path / "truth", tmp_path / "predictions"
    for name in ("1", "2", "3", "4"):
        write_partnet_mobility(TRUTH, TRUTH.mobility, truth / name)
    write_urdf(TRUTH, TRUTH.mobility, predictions / "1")
    write_urdf(
        TRUTH, with_joint(1, replace(DOOR, direction=np.array([1.0, 0, 0]))), predictions / "2", ExportOptions(name="mobility")
    )
    (predictions / "3.urdf").write_text("<robot/>")
    return truth, predictions


def test_failed_and_missing_objects_are_counted(tmp_path):
    truth, predictions = folders(tmp_path)
    seen = []
    report = score_urdf_folder(predictions, truth, progress=lambda done, total: seen.append((done, total)))
    assert [scored.status for scored in report.objects] == ["scored", "scored", "failed", "missing"]
    assert seen[-1] == (4, 4)
    figures = json.loads(json.dumps(summarise_urdf_scores(report), allow_nan=False))
    assert figures["micro"]["recall"]["value"] == pytest.approx(0.5)
    assert figures["micro"]["recall_scored"]["value"] == 1.0
    assert figures["micro"]["precision"]["value"] == 1.0
    assert figures["micro"]["strict_a5"]["value"] == pytest.approx(5 / 12)
    assert figures["micro"]["a5"]["value"] == pytest.approx(5 / 6)
    assert figures["micro"]["angle"]["value"] == pytest.approx(15.0)
    assert figures["categories"]["cabinet"]["failed"] == 1


BOX = '<link name="{0}"><visual>{1}<geometry><box size="{2}"/></geometry></visual></link>'
MESH = '<link name="a"><visual><geometry><mesh filename="{0}" scale="{1}"/></geometry></visual></link>'
FAR = '<origin xyz="1e308 1e308 1e308"/>'
FASTENED = f'<joint type="fixed"><parent link="a"/><child link="b"/>{FAR}</joint>'
BAD = {
    "too large": (BOX.format("a", "", "1e200 1e200 1e200"), "size: expected 3 finite numbers"),
    "too far": (BOX.format("a", FAR, "1 1 1") + BOX.format("b", FAR, "1 1 1") + FASTENED, "xyz: expected 3 finite numbers"),
    "long name": (MESH.format(300 * "x", "1 1 1"), "expected a mesh file, found none"),
    "point": (BOX.format("a", "", "0 0 0"), "expected a prediction with geometry"),
    "nearly a point": (BOX.format("a", "", "1e-170 1e-170 1e-170"), "expected a prediction with geometry"),
    "scaled to a point": (MESH.format("1/meshes/part_1.obj", "0 0 0"), "expected a prediction with geometry"),
    "at another star": (BOX.format("a", FAR.replace("308", "29"), "1 1 1"), "expected finite coordinates of at most 1e+12"),
}


def test_a_broken_urdf_fails_with_one_line_and_the_others_are_scored(tmp_path):
    truth, predictions = folders(tmp_path)
    for name, (inside, _) in BAD.items():
        write_partnet_mobility(TRUTH, TRUTH.mobility, truth / name)
        (predictions / f"{name}.urdf").write_text(f"<robot name='r'>{inside}</robot>")
    report = score_urdf_folder(predictions, truth, ids=["1", *BAD])
    assert {scored.id: scored.status for scored in report.objects} == {"1": "scored", **dict.fromkeys(BAD, "failed")}
    for scored in report.objects[1:]:
        assert BAD[scored.id][1] in scored.reason
        assert "\n" not in scored.reason


@pytest.mark.parametrize("error", [PermissionError(13, "no"), ValueError("a\nb"), ZeroDivisionError("no"), IndexError("no")])
def test_unexpected_errors_are_failures_too(tmp_path, monkeypatch, error):
    def fail(*_):
        raise error

    monkeypatch.setattr(scoring, "robot_bodies", fail)
    score = scored(tmp_path)
    assert score.status == "failed"
    assert f"model.urdf: cannot be scored ({type(error).__name__}: " in score.reason
    assert "\n" not in score.reason


def test_the_number_of_workers_does_not_change_the_scores(tmp_path):
    truth, predictions = folders(tmp_path)
    alone = score_urdf_folder(predictions, truth, ids=["1", "2"])
    assert score_urdf_folder(predictions, truth, ids=["2", "1"], workers=2) == alone


def test_an_unreadable_truth_is_no_failure_of_a_prediction(tmp_path):
    truth, predictions = folders(tmp_path)
    (truth / "1" / "result.json").write_text("[")
    report = score_urdf_folder(predictions, truth, ids=["1"])
    assert not report.objects
    assert "result.json" in report.unreadable["1"]


def test_pseudo_labels_hidden_folders_and_copies_are_no_truths(tmp_path, monkeypatch):
    """They are not scored against. A single shape is named after its folder."""
    truth, predictions = folders(tmp_path)
    write_partnet_mobility(TRUTH, TRUTH.mobility, truth / ".old" / "5")
    write_partnet_mobility(TRUTH, TRUTH.mobility, truth / "5", ExportOptions(meta={PSEUDO_LABEL: {}}))
    write_partnet_mobility(TRUTH, with_joint(1, replace(DOOR, direction=np.array([1.0, 0, 0]))), truth / "z" / "1")
    write_partnet_mobility(TRUTH, TRUTH.mobility, truth / "z" / "2")
    (predictions / "5.urdf").write_text("<robot/>")
    report = score_urdf_folder(predictions, truth)
    assert [scored.id for scored in report.objects] == ["1", "2", "3", "4"]
    assert {name: "differs from another copy of 1" in text for name, text in report.unreadable.items()} == {
        "5": False,
        str(truth / "z" / "1"): True,
    }
    assert "predicted, not annotated" in report.unreadable["5"]
    monkeypatch.chdir(truth / "1")
    alone = score_urdf_folder(predictions, Path())
    assert [(scored.id, scored.status) for scored in alone.objects] == [("1", "scored")]


def test_no_readable_truth_is_a_failure_of_the_command(tmp_path):
    truth, predictions = folders(tmp_path)
    for name in "1234":
        (truth / name / "result.json").write_text("[")
    listener = Recorder()
    assert ScoreUrdfs(predictions, truth, Workspace(tmp_path / "w")).run(listener).failed == 4
    assert sum(note.startswith("skipped: ") for note in listener.notes) == 4


def test_wrong_folders_and_ids_raise_input_errors(tmp_path):
    truth, predictions = folders(tmp_path)
    with pytest.raises(InputError, match=r"mobility_v2\.json$"):
        score_urdf_folder(predictions, predictions)
    with pytest.raises(InputError, match="'99'"):
        score_urdf_folder(predictions, truth, ids=["99"])
    (tmp_path / "file").write_text("")
    (tmp_path / "others").mkdir()
    (tmp_path / "others" / "99.urdf").write_text("<robot/>")
    for name in ("absent", "file", "others"):
        with pytest.raises(InputError, match=rf"{name}: expected URDFs named after shapes below .*truth, such as 1\.urdf"):
            score_urdf_folder(tmp_path / name, truth)


def test_an_unknown_category_is_reported_with_the_known_ones(tmp_path):
    truth, predictions = folders(tmp_path)
    (truth / "1" / "result.json").write_text("[")
    listener = Recorder()
    stage = ScoreUrdfs(predictions, truth, Workspace(tmp_path / "w"), "cabinets")
    with pytest.raises(InputError, match=r"no shape of cabinets \(did you mean cabinet\?\); there are cabinet"):
        stage.run(listener)
    assert replace(stage, category="cabinet").run(listener).data["micro"]["objects"] == 3
    assert any("result.json" in note for note in listener.notes)
    assert any(note.startswith("failed: 3: ") for note in listener.notes)


def test_all_tables_are_written_to_the_folder_of_the_result(tmp_path):
    truth, predictions = folders(tmp_path)
    workspace = Workspace(tmp_path / "w")
    outcome = ScoreUrdfs(predictions, truth, workspace).run(Recorder())
    assert outcome.path == workspace.evaluation / "urdf_files"
    assert {path.name for path in outcome.path.iterdir()} == {f"{t}.{e}" for t in ("by_category", "failures") for e in WRITERS}
    assert outcome.path.with_suffix(".json").read_text() == json.dumps(outcome.data, indent=1) + "\n"
    by_category, failures = (read_table(outcome.path / f"{name}.json") for name in ("by_category", "failures"))
    assert outcome.text == as_text(by_category)
    assert (by_category.caption.shapes, by_category.caption.joints) == (4, 12)
    assert [row[0] for row in failures.rows] == ["3", "4"]
    assert "not scored" in failures.caption.title


def test_urdfs_are_found_by_name_then_depth_then_path(tmp_path):
    names = ("7/z/model.urdf", "7/a/b.urdf", "7/c.urdf", "7/d.urdf")
    for name in names:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    for expected in ("7/z/model.urdf", "7/c.urdf", "7/d.urdf", "7/a/b.urdf"):
        assert find_urdf(tmp_path, "7") == tmp_path / expected
        (tmp_path / expected).unlink()
    assert find_urdf(tmp_path, "7") is None
    (tmp_path / "7.urdf").touch()
    assert find_urdf(tmp_path, "7") == tmp_path / "7.urdf"
    assert find_urdf(tmp_path, 255 * "7") is None


def test_the_tables_list_every_category_and_every_failure(tmp_path):
    truth, predictions = folders(tmp_path)
    report = score_urdf_folder(predictions, truth)
    caption = Caption("URDF files", "synthetic", 0, 0, "all", ())
    table = urdf_table(summarise_urdf_scores(report), report, caption)
    assert [row[0] for row in table.rows] == ["cabinet", "all parts", "mean of categories"]
    assert (table.caption.shapes, table.caption.joints) == (4, 12)
    assert [(column.title, table.rows[1][place]) for place, column in enumerate(table.columns) if "median" in column.title] == [
        ("median angle", pytest.approx(0, abs=1e-6)),
        ("median line", pytest.approx(0, abs=1e-6)),
    ]
    failures = urdf_failures_table(report, caption)
    assert [(row[0], row[2]) for row in failures.rows] == [("3", "failed"), ("4", "missing")]
    assert "link" in failures.rows[0][3]
