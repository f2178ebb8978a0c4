"""Networks of whole shapes: one for all categories, or one each."""

from __future__ import annotations

import shutil
from collections.abc import Collection
from pathlib import Path

import pytest
from whole_road import Listener, Road, tiny_config

from kinmo.errors import InputError
from kinmo.pipeline.dataset import open_dataset
from kinmo.pipeline.prepare import Prepare
from kinmo.pipeline.train import Train
from kinmo.splits import Split
from kinmo.workspace import Workspace


def without_shapes_to_choose_by(road: Road, categories: Collection[str], folder: Path) -> Train:
    """Training of networks of which each category has its own; some categories have no validation shapes."""
    to_choose_by = open_dataset(road.workspace).labelled[Split.VALIDATION]
    left_out = {entry.id for entry in to_choose_by if entry.category in categories}
    assert left_out
    shutil.copytree(road.shapes, folder / "shapes", ignore=lambda _, names: [name for name in names if name in left_out])
    Prepare(folder / "shapes", Workspace(folder / "workspace")).run(Listener())
    config = tiny_config(folder)
    text = config.read_text(encoding="utf-8")
    config.write_text(text.replace("[gnn]\n", "[gnn]\nper_category = true\n", 1), encoding="utf-8")
    return Train("gnn", Workspace(folder / "workspace"), str(config), device="cpu")


def test_categories_with_too_few_shapes_for_networks_of_their_own_are_said(road: Road, tmp_path: Path) -> None:
    stage, told = without_shapes_to_choose_by(road, ["Stapler"], tmp_path), Listener()
    left_out = [
        f"no {model} (Stapler): 2 labelled shapes of Stapler to train on and 0 to choose by, both are needed"
        for model in ("gnn_fine", "gnn_coarse")
    ]
    assert stage.plan().steps[-2:] == tuple(left_out)
    assert set(stage.run(told).data) == {"gnn_fine (Laptop)", "gnn_coarse (Laptop)"}
    assert told.notes == left_out
    assert stage.plan().steps == ()


def test_of_few_shapes_some_are_kept_to_choose_by(road: Road, tmp_path: Path) -> None:
    stage = without_shapes_to_choose_by(road, ["Laptop", "Stapler"], tmp_path)
    shared = Train("gnn", stage.workspace, str(tiny_config(tmp_path)), device="cpu")
    count = len(open_dataset(stage.workspace).labelled[Split.TRAIN])
    assert shared.plan().steps[0].startswith(f"train gnn_fine on {count - 1} shapes")
    assert shared.plan().steps[0].endswith("choose by 1")
    assert set(shared.run(Listener()).data) == {"gnn_fine", "gnn_coarse"}
    assert shared.plan().steps == ()


def test_where_no_category_has_enough_shapes_nothing_is_trained(road: Road, tmp_path: Path) -> None:
    stage = without_shapes_to_choose_by(road, ["Laptop", "Stapler"], tmp_path)
    with pytest.raises(InputError, match=r"of Laptop .* and 0 to choose by; .* of Stapler .*: both are needed"):
        stage.run(Listener())
    assert not stage.workspace.models.exists()
