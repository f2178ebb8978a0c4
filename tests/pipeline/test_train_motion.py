"""Networks of whole shapes: one for all categories, or one each."""

from __future__ import annotations

import re
import shutil
from collections.abc import Collection
from pathlib import Path

import pytest
from trained_workspace import Recorder, Trained, tiny_config

from kinmo.core.errors import InputError
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.workspace import Workspace
from kinmo.learning.model_folder import WEIGHTS, ModelFolder
from kinmo.pipeline.motion_models import TRAINERS
from kinmo.pipeline.prepare import Prepare
from kinmo.pipeline.train_motion import Train


def without_shapes_to_choose_by(trained: Trained, categories: Collection[str], folder: Path) -> Train:
    """Training of networks of which each category has its own; some categories have no validation shapes."""
    to_choose_by = open_dataset(trained.workspace).labelled[Split.VALIDATION]
    left_out = {entry.id for entry in to_choose_by if entry.category in categories}
    assert left_out
    shutil.copytree(trained.shapes, folder / "shapes", ignore=lambda _, names: [name for name in names if name in left_out])
    Prepare(folder / "shapes", Workspace(folder / "workspace")).run(Recorder())
    config = tiny_config(folder)
    text = config.read_text(encoding="utf-8")
    config.write_text(text.replace("[gnn]\n", "[gnn]\nper_category = true\n", 1), encoding="utf-8")
    return Train("gnn", Workspace(folder / "workspace"), str(config), device="cpu")


def test_categories_with_too_few_shapes_for_networks_of_their_own_are_said(trained: Trained, tmp_path: Path) -> None:
    stage, told = without_shapes_to_choose_by(trained, ["Stapler"], tmp_path), Recorder()
    left_out = [
        f"no {model} (Stapler): 2 labelled shapes of Stapler to train on and 0 to choose by, both are needed"
        for model in ("gnn_fine", "gnn_coarse")
    ]
    assert stage.plan().steps[-2:] == tuple(left_out)
    assert set(stage.run(told).data) == {"gnn_fine (Laptop)", "gnn_coarse (Laptop)"}
    assert told.notes == left_out
    assert stage.plan().steps == ()


def test_of_few_shapes_some_are_kept_to_choose_by(trained: Trained, tmp_path: Path) -> None:
    stage = without_shapes_to_choose_by(trained, ["Laptop", "Stapler"], tmp_path)
    shared = Train("gnn", stage.workspace, str(tiny_config(tmp_path)), device="cpu")
    count = len(open_dataset(stage.workspace).labelled[Split.TRAIN])
    assert shared.plan().steps[0].startswith(f"train gnn_fine on {count - 1} shapes")
    assert shared.plan().steps[0].endswith("choose by 1")
    assert set(shared.run(Recorder()).data) == {"gnn_fine", "gnn_coarse"}
    assert shared.plan().steps == ()


def test_a_network_of_one_category_lies_beside_those_of_all(trained: Trained, tmp_path: Path) -> None:
    shutil.copytree(trained.workspace.path, tmp_path / "workspace")
    workspace, config = Workspace(tmp_path / "workspace"), str(tiny_config(tmp_path))
    before = ModelFolder(workspace.motion.models).weights_for("axis", "Stapler")
    assert before is not None
    shared, told = before.read_bytes(), Recorder()
    assert set(Train("axis", workspace, config, "laptop", device="cpu").run(told).data) == {"axis (Laptop)", "ranking (Laptop)"}
    assert before.read_bytes() == shared
    assert (
        ModelFolder(workspace.motion.models).weights_for("axis", "Laptop")
        == ModelFolder(workspace.motion.models).folder("axis", "Laptop") / WEIGHTS
    )
    assert ModelFolder(workspace.motion.models).seeds(("axis", "ranking")) == (0,)
    Train("axis", workspace, config, "laptop", seed=3, device="cpu").run(told)
    assert ModelFolder(workspace.motion.models).seeds(("axis", "ranking")) == (0, 3)
    assert not told.notes
    Train("axis", workspace, config, device="cpu").run(told)
    folder = workspace.models / "axis"
    assert f"axis: Laptop go by networks of their own, in {folder}" in told.notes


def test_a_training_that_was_cut_off_goes_on_only_by_the_same_configuration(
    trained: Trained, tmp_path: Path, monkeypatch
) -> None:
    shutil.copytree(trained.workspace.path, tmp_path / "workspace", ignore=shutil.ignore_patterns("models"))
    seen: list[str] = []

    def stopped(*given: object, fingerprint: str, **more: object) -> None:
        seen.append(fingerprint)
        raise InputError("training", "stopped")

    for model, (section, _) in TRAINERS.items():
        monkeypatch.setitem(TRAINERS, model, (section, stopped))
    config = tiny_config(tmp_path)
    for share in ("0.1", "0.1", "0.9"):
        text = re.sub(r"hide_names = [\d.]+", f"hide_names = {share}", config.read_text(encoding="utf-8"), count=1)
        config.write_text(text, encoding="utf-8")
        with pytest.raises(InputError, match="stopped"):
            Train("gnn", Workspace(tmp_path / "workspace"), str(config), device="cpu").run(Recorder())
    assert seen[0] == seen[1] != seen[2]


def test_where_no_category_has_enough_shapes_nothing_is_trained(trained: Trained, tmp_path: Path) -> None:
    stage = without_shapes_to_choose_by(trained, ["Laptop", "Stapler"], tmp_path)
    with pytest.raises(InputError, match=r"of Laptop .* and 0 to choose by; .* of Stapler .*: both are needed"):
        stage.run(Recorder())
    assert not stage.workspace.models.exists()
