"""Results of kinmo for the cabinet, by `CabinetMethod`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest
from predicted_cabinet import CORRECTIONS, PIECES, CabinetMethod, write_cabinet_glb
from trained_workspace import Recorder

import kinmo
from kinmo.core.shape_estimate import PredictionProvenance
from kinmo.dataset.stage import Outcome
from kinmo.dataset.workspace import Workspace
from kinmo.io.readers.overrides_reader import OVERRIDES_FILE
from kinmo.io.readers.stated_facts import NO_FACTS, StatedFacts
from kinmo.pipeline import predict_shapes
from kinmo.pipeline.predict_shapes import PredictShapes, predict_shape


def cabinet_prediction(folder: Path, names: Sequence[str] = tuple(PIECES)) -> kinmo.Prediction:
    """The prediction of `CabinetMethod` for cabinet.glb, which is written into a folder."""
    shape = kinmo.load(write_cabinet_glb(folder / "cabinet.glb", names))
    return kinmo.Prediction(shape, predict_shape(shape, CabinetMethod()), PredictionProvenance(CabinetMethod.weights, {}))


def predict_cabinets(source: Path, out: Path, facts: StatedFacts = NO_FACTS) -> Outcome:
    """Run `kinmo predict` with `CabinetMethod`."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(predict_shapes, "load_trained_or_shipped", lambda *_: CabinetMethod())
        stage = PredictShapes([source], out, Workspace(out.with_name("workspace")), "cabinet", device="cpu", facts=facts)
        return stage.run(Recorder())


def result_in(folder: Path, overrides: str | None = CORRECTIONS) -> Path:
    """A result of `kinmo predict` for cabinet.glb with some overrides.toml beside joints.json, not yet applied."""
    outcome = predict_cabinets(write_cabinet_glb(folder / "cabinet.glb"), folder / "out")
    assert not outcome.failed
    result = folder / "out" / "cabinet"
    if overrides is not None:
        (result / OVERRIDES_FILE).write_text(overrides, encoding="utf-8")
    return result
