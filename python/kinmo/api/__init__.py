"""The public API. Every name here is also a name of `kinmo` itself."""

from kinmo.api.loading import load
from kinmo.api.prediction import PredictedJoint, Prediction
from kinmo.api.predictor import Predictor
from kinmo.api.stages import evaluate, prepare, train
from kinmo.pipeline.scans.scan_predictor import ScanPrediction, ScanPredictor

__all__ = [
    "PredictedJoint",
    "Prediction",
    "Predictor",
    "ScanPrediction",
    "ScanPredictor",
    "evaluate",
    "load",
    "prepare",
    "train",
]
