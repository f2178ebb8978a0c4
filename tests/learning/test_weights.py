"""Trained weights on disk, and the choice of a device."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import torch
from torch import nn

from kinmo.config import SensorConfig
from kinmo.core.errors import InputError
from kinmo.learning.weights import load_weights, pick_device, save_weights


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    path = tmp_path / "net.safetensors"
    save_weights(path, nn.Linear(3, 2), "line", {"width": 3}, {"seed": 1})
    return path


def test_saved_weights_load_unchanged(tmp_path: Path) -> None:
    module, other = nn.Linear(3, 2), nn.Linear(3, 2)
    digest = save_weights(tmp_path / "net.safetensors", module, "line", {"width": 3}, {"seed": 1})
    loaded = load_weights(tmp_path / "net.safetensors", "line")
    loaded.fill(other)
    assert (loaded.config, loaded.facts, loaded.sha256) == ({"width": 3}, {"seed": 1}, digest)
    assert torch.equal(module.weight, other.weight)
    assert torch.equal(module.bias, other.bias)


def test_weights_have_the_permissions_of_other_files(saved: Path) -> None:
    assert saved.stat().st_mode == saved.with_suffix(".json").stat().st_mode


def test_a_configuration_of_another_version_says_to_train_again(saved: Path) -> None:
    with pytest.raises(InputError, match=r"net\.json: config\.width: unknown key.*train it again"):
        load_weights(saved, "line").typed_config(SensorConfig)


def test_weights_of_other_sizes_are_rejected_and_the_tensor_is_named(saved: Path) -> None:
    with pytest.raises(InputError, match=r"net\.safetensors: weight: shape \(2, 3\), expected \(2, 4\)"):
        load_weights(saved, "line").fill(nn.Linear(4, 2))
    with pytest.raises(InputError, match="bias: unexpected tensor"):
        load_weights(saved, "line").fill(nn.Linear(3, 2, bias=False))
    with pytest.raises(InputError, match="missing tensor"):
        load_weights(saved, "line").fill(nn.Sequential(nn.Linear(3, 2)))


def test_weights_of_another_kind_are_rejected(saved: Path) -> None:
    with pytest.raises(InputError, match="kind: expected 'circle', got 'line'"):
        load_weights(saved, "circle")


def test_cut_or_absent_files_are_rejected(saved: Path) -> None:
    saved.write_bytes(saved.read_bytes()[:40])
    with pytest.raises(InputError, match=r"sha256: does not belong to net\.json"):
        load_weights(saved, "line")
    saved.unlink()
    with pytest.raises(InputError, match="expected trained weights"):
        load_weights(saved, "line")
    saved.with_suffix(".json").write_text("{")
    with pytest.raises(InputError, match="expected JSON"):
        load_weights(saved, "line")


def test_a_header_of_another_schema_is_rejected(saved: Path) -> None:
    header = json.loads(saved.with_suffix(".json").read_text())
    saved.with_suffix(".json").write_text(json.dumps({**header, "schema": 99}))
    with pytest.raises(InputError, match="schema: expected 1, got 99"):
        load_weights(saved, "line")


@pytest.mark.parametrize("name", ["cpu", "cpu:0", "cpu:3"])
def test_a_numbered_cpu_is_the_cpu(name: str) -> None:
    assert pick_device(name) == "cpu"


@pytest.mark.parametrize("name", ["meta", "meta:0", "gpu", "cuda:99", "", "cpu:x"])
def test_an_unusable_device_is_rejected(name: str) -> None:
    with pytest.raises(InputError, match=f"--device: '{name}' is not available here"):
        pick_device(name)
