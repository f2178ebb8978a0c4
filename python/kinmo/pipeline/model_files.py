"""Where the networks of a workspace lie. Nothing here needs torch."""

from __future__ import annotations

import json
from pathlib import Path

from kinmo.config import Config, load_config
from kinmo.errors import InputError, expecting
from kinmo.typed_tables import from_table
from kinmo.workspace import Workspace, digest

WEIGHTS = "weights.safetensors"
"""Written into a model's folder when its training is done."""
HEADER = "weights.json"
"""What the weights are for, written right after them."""
METRICS = "metrics.json"
"""One entry an epoch."""
METRICS_TABLE = "metrics.csv"
"""The same as a table."""
CONFIG = "config.json"
"""Beside the motion networks: the configuration of their last training, which prediction follows."""


METHOD_MODELS: dict[str, tuple[str, ...]] = {"kinmo": ("gnn_fine", "ranking"), "paper": ("gnn_fine", "axis")}
"""The models that answer for a shape, by method."""


def model_folder(workspace: Workspace, model: str, category: str | None = None) -> Path:
    """Where a motion network lies; those of a single category have a folder each."""
    folder = workspace.motion.models / model
    return folder / category if category else folder


def weights_for(workspace: Workspace, model: str, category: str) -> Path | None:
    """The trained weights for a shape of `category`: those of the category alone, else those of all, else None."""
    for folder in (model_folder(workspace, model, category), model_folder(workspace, model)):
        if (folder / WEIGHTS).exists():
            return folder / WEIGHTS
    return None


def weights_digest(workspace: Workspace, models: tuple[str, ...]) -> str:
    """A hash of all weights of some models, with those of single categories; empty if one of the models has none."""
    found: dict[str, str] = {}
    for model in models:
        headers = sorted(model_folder(workspace, model).rglob(HEADER))
        if not headers:
            return ""
        for path in headers:
            with expecting("what weights are for", path):
                found[str(path.relative_to(workspace.motion.models))] = json.loads(path.read_text(encoding="utf-8"))["sha256"]
    return digest(found)


def seeds_of(workspace: Workspace, models: tuple[str, ...]) -> tuple[int, ...]:
    """Those that some models were trained with, each once."""
    found = set()
    for path in (path for model in models for path in model_folder(workspace, model).rglob(HEADER)):
        with expecting("what weights are for", path):
            found.add(int(json.loads(path.read_text(encoding="utf-8"))["facts"]["seed"]))
    return tuple(sorted(found))


def networks_digest(paths: tuple[Path, ...]) -> str:
    """A hash of some files of weights and of the configurations they were trained with."""
    found = []
    for path in (path.with_suffix(".json") for path in paths):
        with expecting("what weights are for", path):
            header = json.loads(path.read_text(encoding="utf-8"))
            found.append([header["sha256"], header["config"]])
    return digest(found)


def trained_on(weights: Path) -> tuple[int, int]:
    """How many labelled objects a network for scans was trained on, and how many others, as its header says."""
    path = weights.with_suffix(".json")
    with expecting("what weights are for", path):
        facts = json.loads(path.read_text(encoding="utf-8"))["facts"]
        return int(facts["labelled"]), int(facts["objects"]) - int(facts["labelled"])


def trained_config(workspace: Workspace) -> Config:
    """The configuration that the workspace's networks were trained with; `small` if none was trained."""
    path = workspace.motion.models / CONFIG
    if not path.exists():
        return load_config("small")
    try:
        table = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise InputError(path, f"expected JSON ({error})") from error
    return from_table(Config, table, path)
