"""Scoring all rows of Table 1 on one shape, in both settings."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.config import RefinementConfig
from kinmo.core.normalisation import Normalisation
from kinmo.core.prediction import JointEstimate, Prediction
from kinmo.evaluation.hierarchy_given import hierarchy_given
from kinmo.evaluation.joint_records import ShapeScore, failed_shape, with_edges
from kinmo.evaluation.parts_given import parts_given
from kinmo.evaluation.penetration import PenetrationMeter
from kinmo.experiments.table1.examples import Example, answer_of
from kinmo.experiments.table1.rows import CEILING, NO_LEARNING, Row, frame_answers
from kinmo.experiments.table1.rule_baseline import segmented_without_learning
from kinmo.features.prepared_shape import PreparedShape
from kinmo.methods.method import Method

PICTURED = ("kinmo", "OBB_fine", "GNN_fine", "GNN_coarse")
"""Rows whose answers are kept for the report's pictures."""


@dataclass
class Judgement:
    """Scores of one shape by row in either setting, the answers to be pictured, and what went wrong."""

    parts_given: dict[str, ShapeScore] = field(default_factory=dict)
    hierarchy_given: dict[str, ShapeScore] = field(default_factory=dict)
    examples: list[Example] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)


def judge(
    truth: PreparedShape,
    meshes: _core.Meshes,
    layout: str,
    rows: Sequence[Row],
    config: RefinementConfig,
    trees: Mapping[int, JointEstimate] | None = None,
) -> Judgement:
    """Score every row on the annotated shape `truth`; a row that fails on it has all its joints missed.

    `meshes` are those of the leaves in the normalised frame; `config` says what the paper's candidates are; `trees` is what
    the baseline of boosted trees answers, if there is one.
    """
    result = Judgement()
    answers: dict[str, dict[int, JointEstimate]] = {}
    for name, found in frame_answers(truth, meshes, config, trees):
        result.parts_given[name] = parts_given(truth, found)
    # What candidates allow, they allow of the true bodies in either setting.
    result.hierarchy_given |= {name: score for name, score in result.parts_given.items() if name.startswith(CEILING)}
    result.hierarchy_given[NO_LEARNING] = hierarchy_given(truth, segmented_without_learning(truth))
    given, typed, predicted = (_Shared(truth, meshes, method) for method in ("predict_given", "predict_typed", "predict"))
    meter, frame = PenetrationMeter(meshes, truth.leaves), Normalisation(truth.center, truth.diagonal)
    for row in rows:
        edges = row.predictor.edge_types(truth)
        try:
            prediction = row.of(given(row.predictor))
            answers[row.name] = _best(prediction, truth)
            score = parts_given(
                truth,
                answers[row.name],
                parents=_parents(prediction) if row.predictor.finds_parents else None,
                penetrations=meter.of(frame.mobility(prediction.mobility)),
                told=_best(row.of(typed(row.predictor)), truth),
            )
            result.parts_given[row.name] = _of_types(row, score, truth, edges)
            prediction = row.of(predicted(row.predictor))
            score = hierarchy_given(truth, prediction, penetrations=meter.of(frame.mobility(prediction.mobility)))
            result.hierarchy_given[row.name] = _of_types(row, score, truth, edges)
        except ValueError as error:
            result.failures.append(f"{row.name} on {truth.id}: {error}")
            failed = failed_shape(truth, str(error), is_fine=row.predictor.is_fine)
            for scores in (result.parts_given, result.hierarchy_given):
                scores.setdefault(row.name, failed)
    result.examples = _examples(truth, layout, result.parts_given, answers)
    return result


def _best(prediction: Prediction, truth: PreparedShape) -> dict[int, JointEstimate]:
    """The first answer for every body, in the normalised frame."""
    frame = Normalisation(truth.center, truth.diagonal)
    return {body: frame.estimate(found[0]) for body, found in enumerate(prediction.estimates)}


def _parents(prediction: Prediction) -> dict[int, int | None]:
    return {index: body.parent for index, body in enumerate(prediction.mobility.bodies)}


def _of_types(row: Row, score: ShapeScore, truth: PreparedShape, edges: NDArray[np.int64] | None) -> ShapeScore:
    """The score with the number of types that the row's method tells apart, and with its `edges` where it has any."""
    score = replace(score, is_fine=row.predictor.is_fine)
    return score if edges is None else with_edges(score, truth, edges)


class _Shared:
    """One kind of prediction for one shape, made once a predictor."""

    def __init__(self, truth: PreparedShape, meshes: _core.Meshes, method: str) -> None:
        self.truth, self.meshes, self.method = truth, meshes, method
        self.made: dict[int, Prediction] = {}

    def __call__(self, predictor: Method) -> Prediction:
        if id(predictor) not in self.made:
            ask: Callable[[PreparedShape, _core.Meshes], Prediction] = getattr(predictor, self.method)
            self.made[id(predictor)] = ask(self.truth, self.meshes)
        return self.made[id(predictor)]


def _examples(
    truth: PreparedShape, layout: str, scores: Mapping[str, ShapeScore], answers: Mapping[str, Mapping[int, JointEstimate]]
) -> list[Example]:
    mobility, _ = truth.annotation
    records = {name: {record.body: record for record in scores[name].records} for name in PICTURED if name in answers}
    return [
        Example(
            truth.id,
            layout,
            truth.category,
            body,
            mobility.bodies[body].name,
            truth.body_types[body].name,
            {name: answer_of(found[body], answers[name].get(body)) for name, found in records.items()},
        )
        for body, _ in mobility.movable()
    ]
