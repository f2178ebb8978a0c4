"""Prediction of a folder by a method without networks."""

from __future__ import annotations

from pathlib import Path

import pytest
from rigid_method import RigidMethod

from kinmo.dataset.workspace import Workspace
from kinmo.pipeline import predict_shapes
from kinmo.pipeline.predict_shapes import PredictShapes


@pytest.fixture
def stage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> PredictShapes:
    """Prediction of the folder `shapes` by the method without joints."""
    monkeypatch.setattr(predict_shapes, "load_trained_or_shipped", lambda *_: RigidMethod())
    return PredictShapes([tmp_path / "shapes"], tmp_path / "out", Workspace(tmp_path / "workspace"), "none", device="cpu")
