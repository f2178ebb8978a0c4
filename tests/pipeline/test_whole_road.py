"""From procedural shapes to the report, and the same again."""

from __future__ import annotations

import json
import re
import shutil
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from browser import assert_shown_without_complaint, needs_browser
from kinmo.experiments.table1.evaluate_table1 import Evaluate
from kinmo.experiments.table1.evaluation_folder import SETTINGS
from kinmo.experiments.table1.examples import read_examples
from kinmo.experiments.table1.rows import CONTACT_EDGES, chosen_rows
from kinmo.pipeline.label_decisions import LABELS, decision_path, folder_name
from trained_workspace import METHODS, Recorder, Trained, contents, tiny_config

from kinmo.core.errors import InputError
from kinmo.dataset.journal import runs
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.stage import Stage
from kinmo.dataset.store import PreparedStore
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.scan_tables.make_table import MakeTable
from kinmo.features.prepared_shape import leaf_meshes
from kinmo.io.discover import ShapeSource, discover
from kinmo.io.readers import read_partnet, read_partnet_mobility
from kinmo.io.readers.joints_json_reader import read_joints_json
from kinmo.learning.model_folder import CONFIG, ModelFolder
from kinmo.methods import load_method
from kinmo.pipeline.predict_shapes import Predict
from kinmo.pipeline.prepare import Prepare
from kinmo.pipeline.pseudo_label import PseudoLabel
from kinmo.pipeline.train_motion import Train
from kinmo.view.report import PICTURED_TOGETHER

WANTED_ROWS = ("kinmo", "GNN_coarse", "OBB_coarse", "GNN_fine", "OBB_fine")
STAGES = ("synth", "prepare", "train", "pseudo-label", "eval")
Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""From y up and the front at +z to z up and the front at -y."""


def test_every_stage_says_where_its_result_is(trained: Trained) -> None:
    for name, outcome in trained.outcomes.items():
        assert outcome.path.exists(), name
        assert outcome.failed == 0
        json.dumps(outcome.data)


@pytest.mark.parametrize("name", STAGES)
def test_a_finished_stage_is_not_run_again(name: str, trained: Trained) -> None:
    folder = trained.workspace.path if name != "synth" else trained.shapes
    before, entries = contents(folder), len(runs(trained.workspace))
    again = trained.stages[name].run(Recorder())
    assert contents(folder) == before
    assert len(runs(trained.workspace)) == entries, "the journal has another run"
    assert again.path == trained.outcomes[name].path
    if name != "synth":
        assert again.data == trained.outcomes[name].data


@pytest.mark.parametrize("name", ["synth", "train", "pseudo-label", "eval"])
def test_a_dry_run_of_a_finished_stage_has_nothing_to_do(name: str, trained: Trained) -> None:
    plan = trained.stages[name].plan()
    assert plan.steps == () and plan.seconds == 0


def test_tables_hold_both_methods_in_both_settings(trained: Trained) -> None:
    for setting in SETTINGS:
        rows = [row[0] for row in trained.outcomes["eval"].data[setting]["overview_micro"]["rows"]]
        assert [name for name in rows if name in WANTED_ROWS] == list(WANTED_ROWS)
        assert {"ceiling, paper's candidates", "ceiling, all candidates", "no learning"} <= set(rows)
        for ending in ("txt", "json", "csv", "md", "tex"):
            assert (trained.outcomes["eval"].path / setting / f"angle.{ending}").exists()


def test_axes_are_also_judged_with_the_true_type_given(trained: Trained) -> None:
    table = trained.outcomes["eval"].data["parts_given"]["overview_micro"]
    place = table["columns"].index("axis, type given (deg)")
    assert all(0.0 <= row[place] <= 90.0 for row in table["rows"] if row[0] in WANTED_ROWS)
    summary = json.loads((trained.outcomes["eval"].path / "summaries" / "parts_given.json").read_text(encoding="utf-8"))
    for row in WANTED_ROWS:
        figures = summary[row]["micro"]
        assert figures["typed_axis"]["count"] >= figures["axis"]["count"]


def test_every_true_joint_of_the_test_shapes_has_an_example(trained: Trained) -> None:
    examples = read_examples(trained.outcomes["eval"].path / "examples.jsonl")
    table = trained.outcomes["eval"].data["parts_given"]["overview_micro"]
    joints = table["rows"][0][table["columns"].index("joints")]
    assert len(examples) == joints > 0


def test_what_is_accepted_can_be_read_as_partnet_mobility(trained: Trained) -> None:
    report = trained.outcomes["pseudo-label"].data
    folders = [path.parent for path in trained.workspace.pseudo.glob("*/mobility_v2.json")]
    accepted = int(next(row for row in report["tables"][0]["rows"] if row[0] == "all")[2])
    assert len(folders) == accepted > 0
    for folder in folders:
        shape = read_partnet_mobility(folder)
        assert shape.mobility is not None and list(shape.mobility.movable())


def test_no_labelled_shape_is_pseudo_labelled(trained: Trained) -> None:
    decided = {path.stem for path in (trained.workspace.pseudo / "decisions").glob("*.json")}
    labelled = {found.id for found in discover(trained.shapes / "partnet_mobility")}
    assert decided and not decided & labelled


def test_a_shape_that_cannot_be_read_now_keeps_its_label_and_is_labelled_once_it_can(trained: Trained, tmp_path: Path) -> None:
    shutil.copytree(trained.workspace.path, tmp_path / "workspace")
    workspace = Workspace(tmp_path / "workspace")
    entry = next(each for each in open_dataset(workspace).unlabelled if (workspace.pseudo / folder_name(each)).is_dir())
    label, decision = workspace.pseudo / folder_name(entry) / LABELS, decision_path(workspace, entry)
    before = contents(workspace.pseudo)
    decision.unlink()
    source, away, told = Path(entry.source), tmp_path / "away", Recorder()
    stage = replace(trained.stages["pseudo-label"], workspace=workspace)  # type: ignore[type-var]
    source.rename(away)
    try:
        assert stage.run(told).failed == 1
    finally:
        away.rename(source)
    assert [note for note in told.notes if note.startswith("failed: ") and "missing" in note]
    assert label.exists() and not decision.exists()
    assert stage.plan().steps
    assert stage.run(Recorder()).failed == 0
    assert contents(workspace.pseudo) == before


def test_a_higher_threshold_leaves_fewer_folders(trained: Trained, tmp_path: Path) -> None:
    shutil.copytree(trained.workspace.path, tmp_path / "workspace")
    workspace = Workspace(tmp_path / "workspace")

    def accepted() -> set[str]:
        return {path.parent.name for path in workspace.pseudo.glob("laptop*/mobility_v2.json")}

    before = accepted()
    PseudoLabel(workspace, "laptop", threshold=0.5, device="cpu").run(Recorder())
    assert accepted() < before
    PseudoLabel(workspace, "laptop", threshold=1.0, device="cpu").run(Recorder())
    assert not accepted()


@pytest.mark.parametrize("method", METHODS)
def test_what_is_predicted_of_a_shape_does_not_depend_on_its_annotation(method: str, trained: Trained) -> None:
    """So that labels of held-out shapes may be judged for truth without writing those anew without their joints."""
    predictor = load_method(method, ModelFolder(trained.workspace.models), "cpu")
    store = PreparedStore(trained.workspace.prepared)
    for entry in [entry for entry in store.entries if entry.joint_count][:6]:
        shape = store.load(entry)
        meshes = leaf_meshes(ShapeSource.of(shape).read(), shape)
        bare = replace(shape, mobility=None, body_boxes=None, body_types={}, edge_labels=None)
        told, untold = (predictor.predict(each, meshes) for each in (shape, bare))
        assert [body.leaves for body in told.mobility.bodies] == [body.leaves for body in untold.mobility.bodies]
        for one, other in zip(told.mobility.bodies, untold.mobility.bodies, strict=True):
            assert (one.parent, one.joint is None) == (other.parent, other.joint is None)
            if one.joint is not None and other.joint is not None:
                assert one.joint.kind is other.joint.kind
                assert one.joint.direction == pytest.approx(other.joint.direction)
                assert one.joint.pivot == pytest.approx(other.joint.pivot)


def test_the_report_names_everything_that_was_run(trained: Trained) -> None:
    html = trained.outcomes["report"].path.read_text(encoding="utf-8")
    for run in runs(trained.workspace):
        assert run.stage in html
    for title in ("Table 1, parts given", "Table 1, hierarchy given", "Training", "Pseudo labels"):
        assert title in html


@needs_browser
@pytest.mark.parametrize("width", [400, 1200])
def test_a_browser_shows_the_report_without_complaint(width: int, trained: Trained, tmp_path: Path) -> None:
    assert_shown_without_complaint(trained.outcomes["report"].path.read_text(encoding="utf-8"), width, tmp_path)


def test_predict_goes_on_past_a_bad_shape(trained: Trained, tmp_path: Path) -> None:
    source = tmp_path / "mine"
    some = sorted((trained.shapes / "partnet").iterdir())[:2]
    for folder in some:
        (source / folder.name).mkdir(parents=True)
        for path in folder.rglob("*"):
            target = source / folder.name / path.relative_to(folder)
            target.mkdir(exist_ok=True) if path.is_dir() else target.write_bytes(path.read_bytes())
    (source / some[0].name / "result.json").write_text("[{", encoding="utf-8")
    outcome = Predict(source, tmp_path / "out", trained.workspace, METHODS[0], device="cpu").run(Recorder())
    assert outcome.failed == 1
    assert [path.parent.name for path in (tmp_path / "out").glob("*/joints.json")] == [some[1].name]
    assert (tmp_path / "out" / some[1].name / f"{some[1].name}.urdf").exists()
    before = contents(tmp_path / "out")
    Predict(source, tmp_path / "out", trained.workspace, METHODS[0], device="cpu").run(Recorder())
    assert contents(tmp_path / "out") == before


def test_predict_tells_what_it_had_to_leave_out_of_a_shape(trained: Trained, tmp_path: Path) -> None:
    source = next((trained.shapes / "partnet").iterdir())
    shutil.copytree(source, tmp_path / "shapes" / source.name)
    mesh = sorted((tmp_path / "shapes" / source.name / "objs").glob("*.obj"))[-1]
    mesh.write_text("", encoding="utf-8")
    told = Recorder()
    found = Predict(tmp_path / "shapes", tmp_path / "out", trained.workspace, METHODS[0], device="cpu").run(told)
    (shape,) = found.data["shapes"]
    assert any("no surface" in repair for repair in shape["repairs"])
    assert told.notes == [f"repaired: {shape['id']}: {'; '.join(shape['repairs'])}"]
    assert "1 repaired, 0 left out" in found.text


def test_a_shape_with_z_up_gets_the_joints_of_its_copy_with_y_up(trained: Trained, tmp_path: Path) -> None:
    source = sorted((trained.shapes / "partnet").iterdir())[0]
    standing, lying = tmp_path / "y" / source.name, tmp_path / "z" / source.name
    for copy in (standing, lying):
        shutil.copytree(source, copy)
    for path in (lying / "objs").glob("*.obj"):
        path.write_text(re.sub(r"^v (\S+) (\S+) (\S+)", _z_up, path.read_text(encoding="utf-8"), flags=re.M), encoding="utf-8")
    predict = Predict(standing, tmp_path / "out y", trained.workspace, METHODS[0], device="cpu")
    predict.run(Recorder())
    replace(predict, source=lying, out=tmp_path / "out z", up="z").run(Recorder())
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


def _z_up(corner: re.Match[str]) -> str:
    x, y, z = corner.groups()
    return f"v {x} {-float(z)!r} {y}"


def test_shapes_of_one_name_go_into_folders_named_by_where_they_are(trained: Trained, tmp_path: Path) -> None:
    some = sorted((trained.shapes / "partnet").iterdir())[:2]
    for place, shape in zip(("kitchen", "lab"), some, strict=True):
        shutil.copytree(shape, tmp_path / "shapes" / place / "scene")
    stage = Predict(tmp_path / "shapes", tmp_path / "out", trained.workspace, METHODS[0], device="cpu", metres_per_unit=100.0)
    assert stage.plan().steps == (f"predict 2 shapes into {tmp_path / 'out'}",)
    told = Recorder()
    found = stage.run(told)
    assert [Path(shape["folder"]).name for shape in found.data["shapes"]] == ["kitchen__scene", "lab__scene"]
    for place, shape in zip(("kitchen", "lab"), found.data["shapes"], strict=True):
        assert shape["id"] == "scene" and shape["source"] == str(tmp_path / "shapes" / place / "scene")
        document = json.loads((Path(shape["folder"]) / "joints.json").read_text(encoding="utf-8"))
        assert document["shape"]["source"] == shape["source"]
        across = 100.0 * shape["diagonal"]
        assert f"scene: {across:.0f} m across in its URDF: is a unit a metre? (--metres-per-unit)" in told.notes
        assert 'scale="100.0 100.0 100.0"' in Path(shape["urdf"]).read_text(encoding="utf-8")
    assert stage.plan().steps == (), "it is done"
    with pytest.raises(InputError, match="--out: is the folder with the shapes"):
        replace(stage, out=tmp_path / "shapes").run(Recorder())


def test_predict_never_takes_the_place_of_what_it_did_not_write(trained: Trained, tmp_path: Path) -> None:
    shape = next((trained.shapes / "partnet").iterdir())
    shutil.copytree(shape, tmp_path / shape.name)
    before = contents(tmp_path)
    outcome = Predict(tmp_path / shape.name, tmp_path, trained.workspace, METHODS[0], device="cpu").run(Recorder())
    assert outcome.failed == 1 and "--out" in outcome.data["left_out"][0]
    assert contents(tmp_path) == before


@pytest.mark.parametrize(
    ("file", "text", "stages"),
    [
        ("models/ranking/weights.safetensors", "cut", ("eval", "pseudo-label")),
        ("models/ranking/weights.json", "[]", ("eval", "pseudo-label")),
        ("models/gnn_fine/metrics.json", "[1]", ("report",)),
        ("models/config.json", "{", ("eval",)),
        ("prepared/index.jsonl", "{}", ("train", "eval", "pseudo-label", "report")),
        ("pseudo/acceptance.json", "{}", ("report",)),
    ],
)
def test_a_garbled_file_is_named_and_nothing_is_lost(
    file: str, text: str, stages: tuple[str, ...], trained: Trained, tmp_path: Path
) -> None:
    shutil.copytree(trained.workspace.path, tmp_path / "workspace")
    (tmp_path / "workspace" / file).write_text(text, encoding="utf-8")
    before = contents(tmp_path)
    for name in stages:
        stage = replace(trained.stages[name], workspace=Workspace(tmp_path / "workspace"))  # type: ignore[type-var]
        with pytest.raises(InputError, match=Path(file).stem):
            stage.run(Recorder())
        assert contents(tmp_path) == before, name


@pytest.mark.parametrize(
    ("file", "stage"),
    [
        ("models/gnn_fine/metrics.json", "train"),
        ("models/ranking/weights.safetensors", "train"),
        ("models/axis/weights.json", "train"),
        ("pseudo/acceptance.json", "pseudo-label"),
        ("eval/all/examples.jsonl", "eval"),
        ("eval/all/parts_given/angle.json", "eval"),
    ],
)
def test_what_was_damaged_is_made_again(file: str, stage: str, trained: Trained, tmp_path: Path) -> None:
    shutil.copytree(trained.workspace.path, tmp_path / "workspace")
    again = replace(trained.stages[stage], workspace=Workspace(tmp_path / "workspace"))  # type: ignore[type-var]
    assert again.plan().steps == ()
    damaged = tmp_path / "workspace" / file
    damaged.write_bytes(damaged.read_bytes()[:-3])
    assert len(again.plan().steps) == 1


def test_categories_are_matched_whatever_their_spelling(trained: Trained) -> None:
    plans = [Evaluate(trained.workspace, METHODS, name, device="cpu").plan().steps for name in ("Laptop", "LAPTOP")]
    assert plans[0] == plans[1] != ()
    with pytest.raises(InputError, match="Stapler"):
        Evaluate(trained.workspace, METHODS, "spoon").plan()


@pytest.mark.parametrize(
    "stage",
    [
        Train("motion", Workspace(Path("nowhere")), "small"),
        Evaluate(Workspace(Path("nowhere")), METHODS),
        PseudoLabel(Workspace(Path("nowhere"))),
    ],
)
def test_a_stage_without_its_inputs_says_what_to_run_first(
    stage: Stage, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="kinmo prepare"):
        stage.run(Recorder())
    assert not list(tmp_path.iterdir())


def test_pictures_are_drawn_from_the_sources(trained: Trained) -> None:
    html = trained.outcomes["report"].path.read_text(encoding="utf-8")
    examples = read_examples(trained.outcomes["eval"].path / "examples.jsonl")
    pictured = [row for example in examples for row, _ in PICTURED_TOGETHER if row in example.answers]
    assert html.count('<svg class="object"') == len(pictured) > 0
    assert all(found.read() for found in list(discover(trained.shapes / "partnet_mobility"))[:1])


def test_a_run_for_one_category_leaves_the_report_of_the_others(trained: Trained, tmp_path: Path) -> None:
    shutil.copytree(trained.workspace.path, tmp_path / "workspace")
    workspace = Workspace(tmp_path / "workspace")
    stale = workspace.pseudo / "no such shape"
    stale.mkdir()
    before = PseudoLabel(workspace, threshold=0.0, device="cpu")
    outcome = PseudoLabel(workspace, "laptop", threshold=1.0, device="cpu").run(Recorder())
    categories = {row[0]: row for row in outcome.data["tables"][0]["rows"]}
    assert set(categories) > {"Laptop", "all"}
    assert int(categories["Laptop"][2]) == 0
    assert len(outcome.data["ways"]) == 2
    assert not stale.exists()
    own = replace(before, category="stapler")
    assert own.plan().steps == ("report on the pseudo labels that there are now",), "all of it is labelled so already"
    assert before.run(Recorder()).data["tables"] == trained.outcomes["pseudo-label"].data["tables"]
    assert before.plan().steps == ()
    shutil.rmtree(next(workspace.pseudo.glob(f"*/{LABELS}")).parent)
    assert [step.split(" by ")[0] for step in before.plan().steps] == ["label 1 shape"], "what was accepted is gone"


def test_labels_of_other_categories_that_would_be_others_now_are_said_to_be_so(trained: Trained, tmp_path: Path) -> None:
    shutil.copytree(trained.workspace.path, tmp_path / "workspace")
    workspace = Workspace(tmp_path / "workspace")
    config = workspace.models / CONFIG
    table = json.loads(config.read_text(encoding="utf-8"))
    table["refinement"]["doubt"] += 0.01
    config.write_text(json.dumps(table), encoding="utf-8")
    others = sorted({row[0] for row in trained.outcomes["pseudo-label"].data["tables"][0]["rows"]} - {"Laptop", "all"})
    text = PseudoLabel(workspace, "laptop", device="cpu").run(Recorder()).text
    assert f" Those of {', '.join(others)} would be labelled otherwise now" in text
    assert "otherwise" not in PseudoLabel(workspace, device="cpu").run(Recorder()).text


def test_tables_say_how_far_predicted_motions_run_into_the_rest(trained: Trained) -> None:
    for setting in SETTINGS:
        table = trained.outcomes["eval"].data[setting]["overview_micro"]
        place = table["columns"].index("penetration")
        shares = [row[place] for row in table["rows"] if row[place] is not None]
        assert shares and all(0.0 <= share <= 1.0 for share in shares)


def test_edges_are_scored_where_a_method_classes_them(trained: Trained) -> None:
    table = trained.outcomes["eval"].data["parts_given"]["overview_micro"]
    place = table["columns"].index("edges")
    edges = {row[0]: row[place] for row in table["rows"]}
    assert edges["kinmo"] is None
    assert all(0.0 <= edges[name] <= 1.0 for name in ("GNN_coarse", "GNN_fine", "OBB_fine"))


def test_every_figure_has_its_interval_in_the_summaries(trained: Trained) -> None:
    for setting in SETTINGS:
        found = json.loads((trained.outcomes["eval"].path / "summaries" / f"{setting}.json").read_text(encoding="utf-8"))
        for summary in found.values():
            figures = [figure for figure in summary["micro"].values() if figure is not None]
            assert figures and all(figure["low"] <= figure["high"] for figure in figures)


def test_rows_of_contact_edges_need_a_network_that_was_trained_so(trained: Trained, tmp_path: Path) -> None:
    shutil.copytree(trained.workspace.path, tmp_path / "workspace")
    workspace = Workspace(tmp_path / "workspace")

    def rows() -> list[str]:
        return [row.name for row in chosen_rows(workspace, ("paper",), "cpu", ablations=True)]

    assert CONTACT_EDGES not in rows()
    Train("contact-edges", workspace, str(tiny_config(tmp_path)), device="cpu").run(Recorder())
    assert CONTACT_EDGES in rows()


def test_ranking_goes_on_from_another_workspace(trained: Trained, tmp_path: Path) -> None:
    workspace = Workspace(tmp_path / "workspace")
    shutil.copytree(trained.workspace.prepared, workspace.prepared)
    stage = Train("axis", workspace, str(tiny_config(tmp_path)), device="cpu", start=trained.workspace)
    assert any("for 1 epoch," in step for step in stage.plan().steps if "axis" in step)
    assert any("for 14 epochs" in step for step in stage.plan().steps if "ranking" in step)
    stage.run(Recorder())
    start = json.loads((trained.workspace.models / "ranking" / "weights.json").read_text(encoding="utf-8"))
    header = json.loads((workspace.models / "ranking" / "weights.json").read_text(encoding="utf-8"))
    assert header["facts"]["started_from"] == start["sha256"]
    assert not stage.plan().steps


def test_a_workspace_without_ranking_networks_is_nothing_to_go_on_from(trained: Trained, tmp_path: Path) -> None:
    listener, record = Recorder(), trained.workspace.record("train-axis")
    stage = Train("motion", trained.workspace, "small", start=Workspace(tmp_path))
    for call in (stage.plan, lambda: stage.run(listener)):
        with pytest.raises(InputError, match="weights to go on from"):
            call()
    assert listener.steps == [] and trained.workspace.record("train-axis") == record  # not after hours of other networks


def test_weights_to_go_on_from_are_looked_at_before_anything_is_trained(trained: Trained, tmp_path: Path) -> None:
    start, listener = Workspace(tmp_path / "start"), Recorder()
    shutil.copytree(trained.workspace.models / "ranking", start.models / "ranking")
    weights = start.models / "ranking" / "weights.safetensors"
    weights.write_bytes(weights.read_bytes()[:100])
    stage = Train("motion", trained.workspace, "small", start=start)
    for call in (stage.plan, lambda: stage.run(listener)):
        with pytest.raises(InputError, match=r"weights\.safetensors: sha256"):
            call()
    assert listener.steps == []


@pytest.mark.parametrize(("size", "value"), [("members", 7), ("width", 256)])
def test_networks_of_other_sizes_are_nothing_to_go_on_from(trained: Trained, tmp_path: Path, size: str, value: int) -> None:
    config, workspace, listener = tiny_config(tmp_path), Workspace(tmp_path / "workspace"), Recorder()
    shutil.copytree(trained.workspace.prepared, workspace.prepared)
    known = json.loads((trained.workspace.models / "ranking" / "weights.json").read_text(encoding="utf-8"))["config"][size]
    lines = [line for line in config.read_text(encoding="utf-8").splitlines() if not line.startswith(f"{size} =")]
    lines.insert(lines.index("[ranking]") + 1, f"{size} = {value}")
    config.write_text("\n".join(lines), encoding="utf-8")
    stages = [
        Train("motion", workspace, str(config), device="cpu", start=trained.workspace),
        MakeTable("2", workspace, str(config), ("kinmo",), "laptop", device="cpu", start=trained.workspace),
    ]
    for call in [call for stage in stages for call in (stage.plan, partial(stage.run, listener))]:
        with pytest.raises(InputError, match=f"--from: trained with ranking.{size} = {known}, expected {value}"):
            call()
    assert listener.steps == []


def test_a_workspace_does_not_go_on_from_itself(trained: Trained) -> None:
    with pytest.raises(InputError, match=r"--from: .* is the workspace itself"):
        Train("axis", trained.workspace, "small", start=Workspace(trained.workspace.root / ".." / trained.workspace.root.name)).plan()


def test_shapes_that_a_workspace_loses_are_counted(trained: Trained, tmp_path: Path) -> None:
    workspace, listener = Workspace(tmp_path / "workspace"), Recorder()
    shutil.copytree(trained.workspace.prepared, workspace.prepared)
    Prepare(trained.shapes, workspace).run(listener)
    assert listener.notes == []
    Prepare(trained.shapes / "partnet", workspace).run(listener)
    lost = len(PreparedStore(trained.workspace.prepared)) - len(PreparedStore(workspace.prepared))
    assert [note.split()[0] for note in listener.notes] == [str(lost)] != ["0"]


def test_networks_that_cannot_start_from_trained_weights_say_so(trained: Trained) -> None:
    for group, able in (("gnn", "motion or axis"), ("paper", "kinmo")):
        with pytest.raises(InputError, match=f"--from: {group} cannot start from trained weights; use it with {able}$"):
            Train(group, trained.workspace, "small", start=trained.workspace).plan()
