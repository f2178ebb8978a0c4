"""Joints for 3D objects: kinmo predicts how the parts of an object move.

Example:
    >>> import kinmo
    >>> shape = kinmo.load("cabinet.glb")
    >>> prediction = kinmo.Predictor("workspace").predict(shape)
    >>> prediction.export("out/cabinet", formats=["urdf"])
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from kinmo._core import __version__

if TYPE_CHECKING:
    from kinmo.api.load import load
    from kinmo.api.prediction import PredictedJoint, Prediction
    from kinmo.api.predictor import Predictor
    from kinmo.api.stages import evaluate, export, prepare, train
    from kinmo.core.errors import InputError, KinmoError
    from kinmo.core.joint import Joint, JointKind
    from kinmo.core.mobility import Body, Mobility
    from kinmo.core.shape import Mesh, Part, Shape
    from kinmo.pipeline.scans.scan_predictor import ScanPrediction, ScanPredictor

__all__ = [
    "Body",
    "InputError",
    "Joint",
    "JointKind",
    "KinmoError",
    "Mesh",
    "Mobility",
    "Part",
    "PredictedJoint",
    "Prediction",
    "Predictor",
    "ScanPrediction",
    "ScanPredictor",
    "Shape",
    "__version__",
    "evaluate",
    "export",
    "load",
    "prepare",
    "train",
]

_MODULES = {
    "api.load": ("load",),
    "api.prediction": ("PredictedJoint", "Prediction"),
    "api.predictor": ("Predictor",),
    "api.stages": ("evaluate", "export", "prepare", "train"),
    "core.errors": ("InputError", "KinmoError"),
    "core.joint": ("Joint", "JointKind"),
    "core.mobility": ("Body", "Mobility"),
    "core.shape": ("Mesh", "Part", "Shape"),
    "pipeline.scans.scan_predictor": ("ScanPrediction", "ScanPredictor"),
}
_HOME = {name: module for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used, so that `import kinmo` does not load PyTorch."""
    if name not in _HOME:
        raise AttributeError(f"module 'kinmo' has no attribute {name!r}")
    return getattr(import_module(f"kinmo.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
