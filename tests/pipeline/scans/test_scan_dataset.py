"""The scans that networks of a category learn from and are judged on."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
from scan_road import CATEGORY, Scanned

from kinmo.core.errors import InputError
from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.scans.scan_dataset import open_scan_dataset


def test_fewer_labels_are_fewer_scans_to_train_on_and_more_that_are_hidden(scanned: Scanned) -> None:
    whole = open_scan_dataset(scanned.workspace, CATEGORY)
    part = open_scan_dataset(Workspace(scanned.workspace.root, 0.3), CATEGORY)
    assert part.structure == whole.structure
    assert part.files["test"] == whole.files["test"] or [f.id for f in part.files["test"]] == [
        f.id for f in whole.files["test"]
    ]
    assert 0 < len(part.files["train"]) < len(whole.files["train"])
    ids = {role: ({f.id for f in whole.files[role]}, {f.id for f in part.files[role]}) for role in ("train", "hidden")}
    assert ids["hidden"][1] == ids["hidden"][0] | (ids["train"][0] - ids["train"][1])


def test_a_setting_without_anything_of_its_own_is_none(scanned: Scanned) -> None:
    for setting, objects in (("semi-weakly", "objects"), ("dsg-net", "objects in DSG-Net's layout")):
        problem = f"{setting}: needs scans of pseudo-labelled {objects} with 2 parts (revolute on part 0), and there are none"
        with pytest.raises(InputError, match=re.escape(f"{problem}: run kinmo pseudo-label, then kinmo render")):
            scanned.train(setting).plan()


def test_objects_that_stand_in_for_validation_ones_are_the_same_for_all_shares_of_labels(
    scanned: Scanned, tmp_path: Path
) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    shutil.rmtree(tmp_path / "workspace" / "scans" / CATEGORY / "validation")
    found = set()
    for share in (1.0, 0.5, 0.1):
        dataset = open_scan_dataset(Workspace(tmp_path / "workspace", share), CATEGORY)
        ids = {role: {file.id for file in dataset.files[role]} for role in ("train", "validation", "hidden")}
        assert ids["train"]
        assert not ids["validation"] & ids["hidden"]
        assert len(ids["train"]) == 1 or not ids["validation"] & ids["train"]
        found.add(frozenset(ids["validation"]))
    (same,) = found
    assert same
