"""Training of motion networks: one for all categories or one each, and training that continues from other networks."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Collection
from functools import partial
from pathlib import Path

import pytest
from trained_workspace import Recorder, Trained, tiny_config

from kinmo.core.errors import InputError
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.scan_tables.make_table import MakeTable
from kinmo.learning.model_folder import WEIGHTS, ModelFolder
from kinmo.pipeline.motion_models import TRAINERS
from kinmo.pipeline.prepare_shapes import Prepare
from kinmo.pipeline.train_motion import TrainMotion


def without_shapes(trained: Trained, splits: Collection[Split], folder: Path) -> TrainMotion:
    """Training in a workspace that has no labelled shapes in some splits."""
    labelled = open_dataset(trained.workspace).labelled
    removed = {entry.id for split in splits for entry in labelled[split]}
    assert removed
    shutil.copytree(trained.shapes, folder / "shapes", ignore=lambda _, names: [name for name in names if name in removed])
    Prepare(folder / "shapes", Workspace(folder / "workspace")).run(Recorder())
    return TrainMotion("gnn", Workspace(folder / "workspace"), str(tiny_config(folder)), device="cpu")


def empty_workspace(trained: Trained, folder: Path) -> Workspace:
    """A workspace with the same prepared shapes and without networks."""
    return Workspace(folder / "workspace", prepared=trained.workspace.prepared)


def test_without_validation_shapes_some_training_shapes_validate(trained: Trained, tmp_path: Path) -> None:
    stage = without_shapes(trained, [Split.VALIDATION], tmp_path)
    count = len(open_dataset(stage.workspace).labelled[Split.TRAIN])
    assert stage.plan().steps[0].startswith(f"train gnn_fine on {count - 1} shapes")
    assert stage.plan().steps[0].endswith("validate on 1")
    assert set(stage.run(Recorder()).data) == {"gnn_fine", "gnn_coarse"}
    assert stage.plan().steps == ()


def test_nothing_is_trained_without_training_shapes(trained: Trained, tmp_path: Path) -> None:
    stage = without_shapes(trained, [Split.TRAIN], tmp_path)
    for call in (stage.plan, lambda: stage.run(Recorder())):
        with pytest.raises(
            InputError, match=r"prepared: found 0 labelled shapes for training and \d+ for validation, expected both"
        ):
            call()
    assert not stage.workspace.models.exists()


def test_a_network_for_one_category_lies_beside_that_for_all(trained: Trained, tmp_path: Path) -> None:
    workspace, config = trained.copy(tmp_path), str(tiny_config(tmp_path))
    models, recorder = ModelFolder(workspace.models), Recorder()
    shared = models.weights_for("axis", "Stapler")
    before = shared.read_bytes()
    outcome = TrainMotion("paper", workspace, config, "pliers", device="cpu").run(recorder)
    assert set(outcome.data) == {"gnn_fine (Pliers)", "axis (Pliers)"}
    assert shared.read_bytes() == before
    assert models.weights_for("axis", "Pliers") == models.folder("axis", "Pliers") / WEIGHTS
    assert models.seeds(("axis", "gnn_fine")) == (0,)
    TrainMotion("paper", workspace, config, "pliers", seed=3, device="cpu").run(recorder)
    assert models.seeds(("axis", "gnn_fine")) == (0, 3)
    assert not recorder.notes
    TrainMotion("axis", workspace, config, device="cpu").run(recorder)
    assert f"axis: Pliers have networks of their own in {workspace.models / 'axis'}" in recorder.notes


def test_an_interrupted_training_continues_only_with_the_same_configuration(
    trained: Trained, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fingerprints: list[str] = []

    def interrupted(*given: object, fingerprint: str, **options: object) -> None:
        fingerprints.append(fingerprint)
        raise InputError("training", "interrupted")

    for model, (section, _) in TRAINERS.items():
        monkeypatch.setitem(TRAINERS, model, (section, interrupted))
    config, workspace = tiny_config(tmp_path), empty_workspace(trained, tmp_path)
    for share in ("0.1", "0.1", "0.9"):
        text = re.sub(r"hide_names = [\d.]+", f"hide_names = {share}", config.read_text(encoding="utf-8"), count=1)
        config.write_text(text, encoding="utf-8")
        with pytest.raises(InputError, match="interrupted"):
            TrainMotion("gnn", workspace, str(config), device="cpu").run(Recorder())
    assert fingerprints[0] == fingerprints[1] != fingerprints[2]


def test_the_kinmo_method_continues_from_another_workspace(trained: Trained, tmp_path: Path) -> None:
    workspace, config = empty_workspace(trained, tmp_path), tiny_config(tmp_path)
    epochs = {"grouping": 2, "ranking": 1, "limits": 3}
    continued = {"grouping": "grouping.continued", "ranking": "ranking.continued.training", "limits": "limits.continued"}
    text = "".join(
        f"[{section}]\nepochs = {epochs[model]}\nlearning_rate = 5e-4\nweight_decay = 0.0\ndecay_epochs = 0\nthreads = 1\n"
        for model, section in continued.items()
    )
    config.write_text(f"{config.read_text(encoding='utf-8')}\n{text}", encoding="utf-8")
    stage = TrainMotion("kinmo", workspace, str(config), device="cpu", start=trained.workspace)
    for step, (model, count) in zip(stage.plan().steps, epochs.items(), strict=True):
        assert step.startswith(f"train {model}") and f"for {count} epoch" in step
    stage.run(Recorder())
    for model in epochs:
        start, header = (
            json.loads((place.models / model / "weights.json").read_text(encoding="utf-8"))
            for place in (trained.workspace, workspace)
        )
        assert header["facts"]["started_from"] == start["sha256"]
    assert not stage.plan().steps


def test_the_ranking_is_trained_again_after_the_grouping(trained: Trained, tmp_path: Path) -> None:
    workspace, config = trained.copy(tmp_path), tiny_config(tmp_path)
    text = config.read_text(encoding="utf-8")
    assert not TrainMotion("kinmo", workspace, str(config), device="cpu").plan().steps
    config.write_text(text.replace("[grouping.training]", "[grouping]\nwidth = 16\n\n[grouping.training]"), encoding="utf-8")
    steps = TrainMotion("kinmo", workspace, str(config), device="cpu").plan().steps
    assert [step.split()[1] for step in steps] == ["grouping", "ranking"]


def test_a_workspace_without_ranking_networks_cannot_be_continued_from(trained: Trained, tmp_path: Path) -> None:
    recorder, record = Recorder(), trained.workspace.inputs_of("train-axis")
    stage = TrainMotion("motion", trained.workspace, "small", start=Workspace(tmp_path))
    for call in (stage.plan, lambda: stage.run(recorder)):
        with pytest.raises(InputError, match="weights to continue from"):
            call()
    assert recorder.steps == [], "the error comes before hours of other trainings"
    assert trained.workspace.inputs_of("train-axis") == record


def test_weights_to_continue_from_are_checked_before_any_training(trained: Trained, tmp_path: Path) -> None:
    start, recorder = Workspace(tmp_path / "start"), Recorder()
    for model in ("grouping", "ranking", "limits"):
        shutil.copytree(trained.workspace.models / model, start.models / model)
    weights = start.models / "ranking" / "weights.safetensors"
    weights.write_bytes(weights.read_bytes()[:100])
    stage = TrainMotion("motion", trained.workspace, "small", start=start)
    for call in (stage.plan, lambda: stage.run(recorder)):
        with pytest.raises(InputError, match=r"weights\.safetensors: sha256"):
            call()
    assert recorder.steps == []


@pytest.mark.parametrize(("size", "value"), [("members", 7), ("width", 256)])
def test_networks_of_other_sizes_cannot_be_continued_from(trained: Trained, tmp_path: Path, size: str, value: int) -> None:
    config, workspace, recorder = tiny_config(tmp_path), empty_workspace(trained, tmp_path), Recorder()
    known = json.loads((trained.workspace.models / "ranking" / "weights.json").read_text(encoding="utf-8"))["config"][size]
    lines = [line for line in config.read_text(encoding="utf-8").splitlines() if not line.startswith(f"{size} =")]
    lines.insert(lines.index("[ranking]") + 1, f"{size} = {value}")
    config.write_text("\n".join(lines), encoding="utf-8")
    stages = [
        TrainMotion("motion", workspace, str(config), device="cpu", start=trained.workspace),
        MakeTable("2", workspace, str(config), ("kinmo",), "pliers", device="cpu", start=trained.workspace),
    ]
    for call in [call for stage in stages for call in (stage.plan, partial(stage.run, recorder))]:
        with pytest.raises(InputError, match=f"--from: trained with ranking.{size} = {known}, expected {value}"):
            call()
    assert recorder.steps == []


def test_a_workspace_does_not_continue_from_itself(trained: Trained) -> None:
    path = trained.workspace.path
    with pytest.raises(InputError, match=r"--from: .* is the workspace itself"):
        TrainMotion("kinmo", trained.workspace, "small", start=Workspace(path / ".." / path.name)).plan()


def test_networks_that_cannot_continue_from_trained_weights_name_those_that_can(trained: Trained) -> None:
    for group, able in (("gnn", "motion"), ("paper", "kinmo")):
        with pytest.raises(InputError, match=f"--from: {group} cannot start from trained weights; use it with {able}$"):
            TrainMotion(group, trained.workspace, "small", start=trained.workspace).plan()
