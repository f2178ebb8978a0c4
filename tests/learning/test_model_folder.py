"""Folders of trained networks: what they were trained with counts, not only their weights."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import pytest

from kinmo.learning.model_folder import SHIPPED, ModelFolder
from kinmo.methods.method import load_network


@pytest.fixture
def folder(tmp_path: Path) -> ModelFolder:
    """A copy of the limits network that comes with kinmo."""
    shutil.copytree(SHIPPED / "models" / "limits", tmp_path / "limits")
    return ModelFolder(tmp_path)


def change_configuration(folder: ModelFolder) -> None:
    """Change a setting that the training does not use."""
    path = folder.folder("limits") / "weights.json"
    header = json.loads(path.read_text(encoding="utf-8"))
    header["config"]["dropout"] = 0.9
    path.write_text(json.dumps(header), encoding="utf-8")
    os.utime(path, ns=(1, 1))  # a clock may be too coarse to show the change


def test_the_digest_changes_with_the_configuration(folder: ModelFolder) -> None:
    before = folder.digest(("limits",))
    assert before == folder.digest(("limits",)) != ""
    change_configuration(folder)
    assert folder.digest(("limits",)) != before
    assert folder.digest(("limits", "ranking")) == "", "one was never trained"


def test_a_network_is_read_again_when_its_configuration_changes(folder: ModelFolder) -> None:
    read = []

    def load(weights: Path) -> int:
        read.append(weights)
        return len(read)

    weights = folder.folder("limits") / "weights.safetensors"
    assert [load_network(load, weights) for _ in range(2)] == [1, 1]
    change_configuration(folder)
    assert load_network(load, weights) == 2
