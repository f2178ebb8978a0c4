"""Scores of all rows of Table 1 on one shape, in both settings: parts given, and hierarchy given."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.normalisation import Normalisation
from kinmo.core.shape_estimate import JointEstimate, ShapeEstimate
from kinmo.dataset.stage import Observer
from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.hierarchy_given import score_hierarchy_given
from kinmo.evaluation.joint_records import ShapeScore, failed_shape, with_edge_types
from kinmo.evaluation.parts_given import score_parts_given
from kinmo.evaluation.penetration import PenetrationMeter
from kinmo.evaluation.score_data import score_from_data, score_to_data
from kinmo.features.prepared_shape import PreparedShape
from kinmo.pipeline.evaluation.evaluation_folder import SETTINGS
from kinmo.pipeline.evaluation.example_predictions import Example, example_from_data, example_prediction
from kinmo.pipeline.evaluation.method_rows import Row

PICTURED_ROWS = ("kinmo", "OBB_fine", "GNN_fine", "GNN_coarse")  # predictions are kept for the report's pictures


@dataclass
class ShapeScores:
    """Scores of one shape by row, with examples for the report's pictures, and messages of the rows that failed."""

    parts_given: dict[str, ShapeScore] = field(default_factory=dict)
    hierarchy_given: dict[str, ShapeScore] = field(default_factory=dict)
    examples: list[Example] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)

    def to_data(self) -> dict[str, Any]:
        """Plain data, which `from_data` reads."""
        scores = {setting: {name: score_to_data(s) for name, s in getattr(self, setting).items()} for setting in SETTINGS}
        return {**scores, "examples": [asdict(example) for example in self.examples], "failures": self.failures}

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> ShapeScores:
        """The scores that `to_data` took apart. Raises KeyError, TypeError, ValueError or AttributeError for other data."""
        given, predicted = ({name: score_from_data(score) for name, score in data[key].items()} for key in SETTINGS)
        return cls(given, predicted, [example_from_data(example) for example in data["examples"]], list(data["failures"]))


class Baselines(Protocol):
    """Rows that need no trained method, such as an upper bound or a simple learner (`experiments.table1`)."""

    def prepare(self, workspace: Workspace, observer: Observer) -> Mapping[str, Any]:
        """Plain data for each test shape of a workspace, by its file in the store, that `score` gets."""

    def score(
        self, truth: PreparedShape, meshes: _core.Meshes, data: Any
    ) -> tuple[dict[str, ShapeScore], dict[str, ShapeScore]]:
        """Scores by row: parts given, and hierarchy given."""

    @property
    def settings(self) -> Mapping[str, Any]:
        """Everything but the data that the scores depend on."""


def evaluate_shape(
    truth: PreparedShape,
    meshes: _core.Meshes,
    layout: str,
    rows: Sequence[Row],
    baselines: tuple[dict[str, ShapeScore], dict[str, ShapeScore]] = ({}, {}),
) -> ShapeScores:
    """Score every row on an annotated shape, whose leaves have these meshes in the normalised frame.

    A row that fails misses all joints. The scores of the baselines (parts given, hierarchy given) stand before the rows.
    """
    result = ShapeScores(dict(baselines[0]), dict(baselines[1]))
    estimates: dict[str, dict[int, JointEstimate]] = {}
    predictions: dict[tuple[int, str], ShapeEstimate] = {}
    meter, frame = PenetrationMeter(meshes, truth.leaves), Normalisation(truth.center, truth.diagonal)

    def predicted(row: Row, how: str) -> ShapeEstimate:
        """Prediction of a row; rows of one method share the method's predictions."""
        key = (id(row.method), how)
        if key not in predictions:
            predictions[key] = getattr(row.method, how)(truth, meshes)
        return row.change(predictions[key]) if row.change else predictions[key]

    def best(prediction: ShapeEstimate) -> dict[int, JointEstimate]:
        """Best estimate for every body, in the normalised frame."""
        return {body: frame.estimate(found[0]) for body, found in enumerate(prediction.estimates)}

    for row in rows:
        edges = row.method.edge_types(truth)
        try:
            prediction = predicted(row, "predict_given")
            estimates[row.name] = best(prediction)
            parents = {index: body.parent for index, body in enumerate(prediction.mobility.bodies)}
            score = score_parts_given(
                truth,
                estimates[row.name],
                parents=parents if row.method.finds_parents else None,
                penetrations=meter.measure(frame.mobility(prediction.mobility)),
                typed_estimates=best(predicted(row, "predict_typed")),
            )
            result.parts_given[row.name] = _with_types(row, score, truth, edges)
            prediction = predicted(row, "predict")
            score = score_hierarchy_given(truth, prediction, penetrations=meter.measure(frame.mobility(prediction.mobility)))
            result.hierarchy_given[row.name] = _with_types(row, score, truth, edges)
        except ValueError as error:
            result.failures.append(f"{row.name} on {truth.id}: {error}")
            failed = failed_shape(truth, str(error), has_fine_types=row.method.is_fine)
            for scores in (result.parts_given, result.hierarchy_given):
                scores.setdefault(row.name, failed)
    result.examples = _examples(truth, layout, result.parts_given, estimates)
    return result


def _with_types(row: Row, score: ShapeScore, truth: PreparedShape, edges: NDArray[np.int64] | None) -> ShapeScore:
    """The score with the number of types that the method tells apart, and with its edge types if it has any."""
    score = replace(score, has_fine_types=row.method.is_fine)
    return score if edges is None else with_edge_types(score, truth, edges)


def _examples(
    truth: PreparedShape,
    layout: str,
    scores: Mapping[str, ShapeScore],
    estimates: Mapping[str, Mapping[int, JointEstimate]],
) -> list[Example]:
    mobility, _ = truth.annotation
    records = {name: {record.body: record for record in scores[name].records} for name in PICTURED_ROWS if name in estimates}
    examples = []
    for index, body in mobility.movable():
        found = {name: example_prediction(own[index], estimates[name].get(index)) for name, own in records.items()}
        kind = truth.body_types[index].name
        examples.append(Example(truth.id, layout, truth.category, index, body.name, kind, found))
    return examples
