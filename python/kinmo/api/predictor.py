"""Prediction of the joints of shapes with trained networks."""

from __future__ import annotations

from pathlib import Path

from kinmo.api.prediction import Prediction
from kinmo.core.shape import Shape
from kinmo.core.shape_estimate import PredictionProvenance
from kinmo.dataset.workspace import Workspace
from kinmo.learning.model_folder import ModelFolder
from kinmo.methods import DEFAULT_METHOD, load_trained_or_shipped
from kinmo.pipeline.predict_shapes import predict_shape


class Predictor:
    """Predicts the joints of shapes.

    Args:
        workspace: Folder of a workspace with trained networks (`kinmo.train`). Without any there, those that come with kinmo
            are used.
        method: `kinmo`, or the paper's method, `paper`.
        device: Where networks run: auto, cpu, cuda, cuda:1, mps.
        seed: Seed of the sampled points.

    Raises:
        InputError: The networks of the method are missing or cannot be read.

    Attributes:
        networks: Where the networks come from: a folder, or "those that come with kinmo".

    Example:
        >>> predictor = kinmo.Predictor()
        >>> prediction = predictor.predict(kinmo.load("cabinet.glb"))
    """

    def __init__(
        self, workspace: Path | str = "workspace", *, method: str = DEFAULT_METHOD, device: str = "auto", seed: int = 0
    ) -> None:
        self.method = load_trained_or_shipped(method, ModelFolder(Workspace(workspace).models), device)
        self.networks = self.method.networks
        self.seed = seed

    def predict(self, shape: Shape) -> Prediction:
        """Predict bodies and joints of one shape from its geometry, hierarchy and part names.

        Args:
            shape: The shape, from `kinmo.load`.

        Returns:
            The prediction, in the shape's own frame and units.

        Raises:
            ValueError: the shape's meshes cannot be used.
        """
        estimate = predict_shape(shape, self.method, seed=self.seed)
        return Prediction(shape, estimate, PredictionProvenance(self.method.weights, self.method.config))
