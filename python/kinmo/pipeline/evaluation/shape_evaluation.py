"""Scores of all rows of Table 1 on one shape, in both settings: parts given, and hierarchy given."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
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
from kinmo.methods.method import Method
from kinmo.pipeline.evaluation.example_predictions import Example, example_from_data, example_prediction
from kinmo.pipeline.evaluation.method_rows import Row

PICTURED_ROWS = ("kinmo", "OBB_fine", "GNN_fine", "GNN_coarse")
"""Rows whose predictions are kept for the report's pictures."""


@dataclass
class ShapeScores:
    """Scores of one shape by row.

    Attributes:
        parts_given: Scores with the true bodies given.
        hierarchy_given: Scores with the part hierarchy alone given.
        examples: Predictions for the report's pictures.
        failures: Messages of rows that failed.
    """

    parts_given: dict[str, ShapeScore] = field(default_factory=dict)
    hierarchy_given: dict[str, ShapeScore] = field(default_factory=dict)
    examples: list[Example] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)

    def to_data(self) -> dict[str, Any]:
        """Plain data, which `from_data` reads."""
        return {
            "parts_given": {name: score_to_data(score) for name, score in self.parts_given.items()},
            "hierarchy_given": {name: score_to_data(score) for name, score in self.hierarchy_given.items()},
            "examples": [asdict(example) for example in self.examples],
            "failures": self.failures,
        }

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> ShapeScores:
        """The scores that `to_data` took apart. Raises KeyError, TypeError, ValueError or AttributeError for other data."""
        return cls(
            {name: score_from_data(score) for name, score in data["parts_given"].items()},
            {name: score_from_data(score) for name, score in data["hierarchy_given"].items()},
            [example_from_data(example) for example in data["examples"]],
            list(data["failures"]),
        )


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
    """Score every row on an annotated shape. A row that fails misses all joints.

    Args:
        truth: The shape with its annotation.
        meshes: Meshes of its leaves, in the normalised frame.
        layout: Dataset layout of the shape.
        rows: The rows.
        baselines: Scores of other rows, parts given and hierarchy given, that stand before them.

    Returns:
        The scores, examples and failures.
    """
    result = ShapeScores(dict(baselines[0]), dict(baselines[1]))
    estimates: dict[str, dict[int, JointEstimate]] = {}
    given, typed, predicted = (_Shared(truth, meshes, name) for name in ("predict_given", "predict_typed", "predict"))
    meter, frame = PenetrationMeter(meshes, truth.leaves), Normalisation(truth.center, truth.diagonal)
    for row in rows:
        edges = row.method.edge_types(truth)
        try:
            prediction = row.change(given(row.method))
            estimates[row.name] = _best(prediction, truth)
            score = score_parts_given(
                truth,
                estimates[row.name],
                parents=_parents(prediction) if row.method.finds_parents else None,
                penetrations=meter.measure(frame.mobility(prediction.mobility)),
                typed_estimates=_best(row.change(typed(row.method)), truth),
            )
            result.parts_given[row.name] = _with_types(row, score, truth, edges)
            prediction = row.change(predicted(row.method))
            score = score_hierarchy_given(truth, prediction, penetrations=meter.measure(frame.mobility(prediction.mobility)))
            result.hierarchy_given[row.name] = _with_types(row, score, truth, edges)
        except ValueError as error:
            result.failures.append(f"{row.name} on {truth.id}: {error}")
            failed = failed_shape(truth, str(error), has_fine_types=row.method.is_fine)
            for scores in (result.parts_given, result.hierarchy_given):
                scores.setdefault(row.name, failed)
    result.examples = _examples(truth, layout, result.parts_given, estimates)
    return result


def _best(prediction: ShapeEstimate, truth: PreparedShape) -> dict[int, JointEstimate]:
    """Best estimate for every body, in the normalised frame."""
    frame = Normalisation(truth.center, truth.diagonal)
    return {body: frame.estimate(found[0]) for body, found in enumerate(prediction.estimates)}


def _parents(prediction: ShapeEstimate) -> dict[int, int | None]:
    return {index: body.parent for index, body in enumerate(prediction.mobility.bodies)}


def _with_types(row: Row, score: ShapeScore, truth: PreparedShape, edges: NDArray[np.int64] | None) -> ShapeScore:
    """The score with the number of types that the method tells apart, and with its edge types if it has any."""
    score = replace(score, has_fine_types=row.method.is_fine)
    return score if edges is None else with_edge_types(score, truth, edges)


class _Shared:
    """One kind of prediction for one shape, made once for each method."""

    def __init__(self, truth: PreparedShape, meshes: _core.Meshes, name: str) -> None:
        self.truth, self.meshes, self.name = truth, meshes, name
        self.made: dict[int, ShapeEstimate] = {}

    def __call__(self, method: Method) -> ShapeEstimate:
        if id(method) not in self.made:
            predict: Callable[[PreparedShape, _core.Meshes], ShapeEstimate] = getattr(method, self.name)
            self.made[id(method)] = predict(self.truth, self.meshes)
        return self.made[id(method)]


def _examples(
    truth: PreparedShape,
    layout: str,
    scores: Mapping[str, ShapeScore],
    estimates: Mapping[str, Mapping[int, JointEstimate]],
) -> list[Example]:
    mobility, _ = truth.annotation
    records = {name: {record.body: record for record in scores[name].records} for name in PICTURED_ROWS if name in estimates}
    return [
        Example(
            truth.id,
            layout,
            truth.category,
            body,
            mobility.bodies[body].name,
            truth.body_types[body].name,
            {name: example_prediction(found[body], estimates[name].get(body)) for name, found in records.items()},
        )
        for body, _ in mobility.movable()
    ]
