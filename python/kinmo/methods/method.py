"""Base class of both methods: trained networks that predict the joints of shapes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.shape_estimate import ShapeEstimate
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.model_folder import SHIPPED, ModelFolder

CACHED_NETWORKS = 24
"""Number of networks that stay in memory."""


class Method(ABC):
    """A trained method: it predicts the joints of shapes, in each shape's own frame and lengths.

    Networks are read from `models` when they are first needed. Networks trained for one category alone take precedence.

    Attributes:
        models: The folder with the trained networks.
        device: Where networks run: auto, cpu, cuda, cuda:1, mps.
        hide_names: Hide the names of all parts from the networks.
        name: Name of the method: `kinmo` or `paper`.
        finds_parents: True if, with parts given, the method also predicts the parent of every body.
    """

    models: ModelFolder
    device: str
    hide_names: bool
    name: ClassVar[str]
    finds_parents: ClassVar[bool]

    @property
    @abstractmethod
    def model_names(self) -> tuple[str, ...]:
        """Names of its models in the folder of trained networks."""

    @property
    @abstractmethod
    def config(self) -> Mapping[str, Any]:
        """Settings that predictions depend on, as plain data."""

    @property
    def is_fine(self) -> bool:
        """True for ten motion types, False for five."""
        return True

    @property
    def networks(self) -> str:
        """Source of its networks, in words."""
        return "those that come with kinmo" if self.models.path.is_relative_to(SHIPPED) else str(self.models.path)

    @cached_property
    def weights(self) -> str:
        """Hash of all networks of the method."""
        return self.models.digest(self.model_names)

    def check(self) -> None:
        """Check that all networks can be read.

        Raises:
            InputError: A network is missing or cannot be read.
        """
        for model in self.model_names:
            for path in self.models.all_weights(model):
                self._load(model, path)

    @abstractmethod
    def predict(self, shape: PreparedShape, meshes: _core.Meshes) -> ShapeEstimate:
        """Predict bodies, ranked joints and limits in the shape's own frame (setting *hierarchy given*).

        The annotation of the shape is not used. `meshes` are those of its leaves in the normalised frame (`leaf_meshes`).
        """

    @abstractmethod
    def predict_given(self, shape: PreparedShape, meshes: _core.Meshes) -> ShapeEstimate:
        """Predict the joints of the annotated bodies (setting *parts given*); their joints and parents are not used."""

    @abstractmethod
    def predict_typed(self, shape: PreparedShape, meshes: _core.Meshes) -> ShapeEstimate:
        """Predict axes with the true motion types given, at least for the bodies whose type `predict_given` gets wrong."""

    def edge_types(self, shape: PreparedShape) -> NDArray[np.int64] | None:
        """Predicted motion type [E] of every edge; None if the method does not use edge types by themselves."""
        return None

    def _network(self, model: str, shape: PreparedShape) -> Any:
        """The network of a model for the shape's category."""
        return self._load(model, self.models.weights_for(model, shape.category))

    @abstractmethod
    def _load(self, model: str, weights: Path) -> Any:
        """A model from its file of weights."""


def load_network(load: Callable[..., Any], weights: Path, *options: object) -> Any:
    """Network that `load(weights, *options)` reads. It stays in memory until its file or the header beside it changes.

    Raises:
        InputError: The file is not a whole file of such weights.
    """
    header = weights.with_suffix(".json")
    written = tuple(path.stat().st_mtime_ns for path in (weights, header) if path.exists())
    return _load_network(load, weights, written, *options)


@lru_cache(maxsize=CACHED_NETWORKS)
def _load_network(load: Callable[..., Any], weights: Path, written: tuple[int, ...], *options: object) -> Any:
    return load(weights, *options)
