"""Folder of trained networks: the path of each network, and the facts that its header states.

The module does not import torch, so that commands which only look up networks start fast.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from kinmo.config import Config, load_config
from kinmo.core.digest import digest
from kinmo.core.errors import InputError, expecting
from kinmo.core.typed_tables import from_table

T = TypeVar("T")

SHIPPED = Path(__file__).parents[1] / "shipped"
"""Workspace with the networks that come with kinmo."""
OTHER_VERSION = "; if another version of kinmo trained it, train it again"
"""Remedy at the end of messages about tensors and configurations that do not fit."""
WEIGHTS = "weights.safetensors"
"""File with the tensors of a network, written when its training is done."""
HEADER = "weights.json"
"""Header of the weights, written right after them: kind of network, configuration, facts about the training."""
METRICS = "metrics.json"
"""Metrics of the training, one entry an epoch."""
METRICS_TABLE = "metrics.csv"
"""The same metrics as a table."""
CONFIG = "config.json"
"""Configuration of the last training, also used for predictions."""


@dataclass(frozen=True)
class ModelFolder:
    """Networks below `path`: one folder a model, with one subfolder for each category that has its own network."""

    path: Path

    def folder(self, model: str, category: str | None = None) -> Path:
        """Folder of a model, or of the model's network for one category."""
        folder = self.path / model
        return folder / category if category else folder

    def weights_for(self, model: str, category: str) -> Path:
        """Weights file for shapes of a category: of its own network, otherwise of the network for all categories.

        Raises:
            InputError: Neither network was trained.
        """
        for folder in (self.folder(model, category), self.folder(model)):
            if (folder / WEIGHTS).exists():
                return folder / WEIGHTS
        raise InputError(self.folder(model), f"not trained for {category}: run kinmo train first")

    def all_weights(self, model: str) -> list[Path]:
        """All weights files of a model, including those for single categories.

        Raises:
            InputError: The model was never trained.
        """
        found = sorted(self.folder(model).rglob(WEIGHTS))
        if not found and not self.path.parent.exists():
            problem = "there is no such workspace: name one by --workspace, or run kinmo train motion first"
            raise InputError(self.path.parent, problem)
        if not found:
            raise InputError(self.folder(model), "not trained yet: run kinmo train motion first")
        return found

    def digest(self, models: tuple[str, ...]) -> str:
        """Hash of all weights of several models and of their configurations; empty if one of them was never trained."""
        found: dict[str, Any] = {}
        for model in models:
            headers = sorted(self.folder(model).rglob(HEADER))
            if not headers:
                return ""
            for path in headers:
                with expecting("a header of weights", path):
                    header = _header(path)
                    found[str(path.relative_to(self.path))] = [header["sha256"], header["config"]]
        return digest(found)

    def seeds(self, models: tuple[str, ...]) -> tuple[int, ...]:
        """Seeds that several models were trained with, sorted and without duplicates."""
        seeds = set()
        for path in (path for model in models for path in self.folder(model).rglob(HEADER)):
            with expecting("a header of weights", path):
                seeds.add(int(_header(path)["facts"]["seed"]))
        return tuple(sorted(seeds))

    def config(self) -> Config:
        """Configuration of the last training; `small` if nothing was trained.

        Raises:
            InputError: The file is not a configuration.
        """
        path = self.path / CONFIG
        if not path.exists():
            return load_config("small")
        try:
            table = json.loads(path.read_text(encoding="utf-8"))
        except ValueError as error:
            raise InputError(path, f"not JSON ({error}): train again") from None
        return saved_config(Config, table, path)


def trained_or_shipped(models: ModelFolder, names: tuple[str, ...]) -> ModelFolder:
    """The folder if one of the models was trained in it, otherwise the networks that come with kinmo, if they include them."""
    shipped = ModelFolder(SHIPPED / "models")
    is_trained = any(any(models.folder(name).rglob(WEIGHTS)) for name in names)
    is_shipped = names and all((shipped.folder(name) / WEIGHTS).exists() for name in names)
    return shipped if is_shipped and not is_trained else models


def networks_digest(weights: tuple[Path, ...]) -> str:
    """Hash of several weights files and of the configurations they were trained with."""
    found = []
    for path in (path.with_suffix(".json") for path in weights):
        with expecting("a header of weights", path):
            header = _header(path)
            found.append([header["sha256"], header["config"]])
    return digest(found)


def trained_on(weights: Path) -> tuple[int, int]:
    """Numbers of labelled objects and of other objects that a network for scans was trained on."""
    path = weights.with_suffix(".json")
    with expecting("a header of weights", path):
        facts = _header(path)["facts"]
        return int(facts["labelled"]), int(facts["objects"]) - int(facts["labelled"])


def _header(path: Path) -> dict[str, Any]:
    header: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return header


def saved_config(kind: type[T], table: Mapping[str, Any], path: Path, prefix: str = "") -> T:
    """Configuration that an earlier training wrote (see `from_table`).

    Raises:
        InputError: It is not a configuration of this version of kinmo.
    """
    try:
        return from_table(kind, table, path, prefix)
    except InputError as error:
        raise InputError(path, error.problem + OTHER_VERSION, error.field) from None
