"""Refinement of predicted joints by candidate axes (paper, section 3.3)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from edge_predictions import predictions_from_labels
from small_shapes import cabinet, cabinet_shape

from kinmo import _core
from kinmo.config import RefinementConfig
from kinmo.core.joint import JointKind
from kinmo.core.motion_types import CoarseType, MotionType
from kinmo.core.shape_estimate import ShapeEstimate
from kinmo.features.candidate_joints import CandidateJoints
from kinmo.features.prepared_shape import PreparedShape, leaf_meshes
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions
from kinmo.methods.paper.mobility_tree import tree_with_given_bodies, tree_with_predicted_bodies
from kinmo.methods.paper.refinement import Refiner

CONFIG = RefinementConfig()


def meshes_of(seed: int) -> _core.Meshes:
    """Meshes of a cabinet's leaves, in the normalised frame."""
    return leaf_meshes(cabinet_shape(seed)[0], cabinet(seed))


def noisy_predictions(shape: PreparedShape, seed: int = 0) -> EdgePredictions:
    """True types, with axis errors of about ten degrees and a twentieth of the diagonal."""
    predictions = predictions_from_labels(shape)
    rng = np.random.default_rng(seed)
    directions = predictions.directions + rng.normal(size=predictions.directions.shape) * 0.12
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return replace(
        predictions, directions=directions, pivots=predictions.pivots + rng.normal(size=predictions.pivots.shape) * 0.03
    )


class TrueAxes:
    """Feasibility 1 for candidates near the true joint of the moving leaves, 0 for others."""

    def __init__(self) -> None:
        self.counts: list[int] = []

    def feasibility(self, shape: PreparedShape, moving: list[int], candidates: CandidateJoints) -> np.ndarray:
        self.counts.append(len(candidates))
        leaves = {shape.leaves[place] for place in moving}
        joint = next(body.joint for body in shape.mobility.bodies if set(body.leaves) <= leaves and body.joint is not None)
        parallel = np.abs(candidates.directions @ joint.direction) > 0.999
        across = np.linalg.norm(np.cross(candidates.pivots - joint.pivot, joint.direction), axis=1)
        return np.where(parallel & ((across < 0.03) | (joint.kind is JointKind.PRISMATIC)), 1.0, 0.0)


def axis_errors(shape: PreparedShape, prediction: ShapeEstimate, refined: bool) -> list[float]:
    """Angles in degrees between true and predicted axes, per movable body."""
    errors = []
    for index, body in shape.mobility.movable():
        found = prediction.mobility.bodies[index].joint if refined else prediction.gnn_estimates[index].joint
        errors.append(np.degrees(np.arccos(min(1.0, abs(found.direction @ body.joint.direction)))))
    return errors


@pytest.mark.parametrize("seed", range(4))
def test_refined_axes_are_axes_of_the_box_and_better_than_regressed_ones(seed: int) -> None:
    shape = cabinet(seed)
    selector = TrueAxes()
    prediction = Refiner(shape, CONFIG, selector).refine(tree_with_given_bodies(shape, noisy_predictions(shape)))
    assert max(axis_errors(shape, prediction, refined=True)) < 1e-6
    assert min(axis_errors(shape, prediction, refined=False)) > 0.5
    expected = {MotionType.P_H: 2, MotionType.R_V_S: 4}
    assert selector.counts == [expected[shape.body_types[i]] for i, _ in shape.mobility.movable()]


@pytest.mark.parametrize("seed", range(4))
def test_predictions_are_in_the_shapes_own_frame(seed: int) -> None:
    shape = cabinet(seed)
    truth, _ = cabinet_shape(seed)
    prediction = Refiner(shape, CONFIG, TrueAxes()).refine(tree_with_given_bodies(shape, predictions_from_labels(shape)))
    for index, body in truth.mobility.movable():
        found = prediction.mobility.bodies[index].joint
        assert found.kind is body.joint.kind
        if found.has_pivot:
            across = np.linalg.norm(np.cross(found.pivot - body.joint.pivot, body.joint.direction))
            assert across < 0.05 * truth.diagonal
            own = prediction.gnn_estimates[index].joint
            np.testing.assert_allclose(np.cross(own.pivot - body.joint.pivot, body.joint.direction), 0, atol=1e-9)


def test_estimates_are_ranked_and_have_their_terms_and_sources() -> None:
    shape = cabinet(0)
    prediction = Refiner(shape, CONFIG, TrueAxes()).refine(tree_with_given_bodies(shape, noisy_predictions(shape)))
    for index, _ in shape.mobility.movable():
        estimates = prediction.estimates[index]
        assert [e.score for e in estimates] == sorted((e.score for e in estimates), reverse=True)
        assert set(estimates[0].terms) == {"feasibility", "direction", "position"}
        assert estimates[0].source == ("box edge" if estimates[0].joint.kind is JointKind.REVOLUTE else "box centre")
        assert estimates[0].joint is prediction.mobility.bodies[index].joint
    assert prediction.estimates[0][0].joint is None


def test_directions_have_the_sense_of_the_regressed_direction() -> None:
    shape = cabinet(1)
    predictions = noisy_predictions(shape)
    for sense in (1.0, -1.0):
        turned = replace(predictions, directions=sense * predictions.directions)
        prediction = Refiner(shape, CONFIG, TrueAxes()).refine(tree_with_given_bodies(shape, turned))
        for index, body in shape.mobility.movable():
            assert sense * (prediction.mobility.bodies[index].joint.direction @ body.joint.direction) > 0.9


def test_coarse_types_use_all_axes_of_the_box() -> None:
    shape = cabinet(0)
    fine = noisy_predictions(shape)
    coarse = np.zeros((len(shape.edges), 5))
    for motion in MotionType:
        coarse[:, motion.coarse] += fine.type_probabilities[:, motion]
    selector = TrueAxes()
    prediction = Refiner(shape, CONFIG, selector).refine(
        tree_with_given_bodies(shape, replace(fine, type_probabilities=coarse))
    )
    assert set(selector.counts) <= {3, 15}
    assert all(isinstance(estimates[0].type, CoarseType) for estimates in prediction.estimates[1:])


@pytest.mark.parametrize("seed", range(4))
def test_drawers_open_to_the_front_alone(seed: int) -> None:
    shape = cabinet(seed)
    meshes = meshes_of(seed)
    prediction = Refiner(shape, CONFIG, TrueAxes(), meshes).refine(
        tree_with_predicted_bodies(shape, predictions_from_labels(shape))
    )
    for body in prediction.mobility.bodies:
        if body.joint is not None:
            assert body.joint.lower <= 0 <= body.joint.upper
            if body.joint.kind is JointKind.PRISMATIC:
                assert body.joint.lower == 0.0
                assert body.joint.upper > 0.1 * shape.diagonal


def test_the_sweep_term_and_extra_candidates_need_meshes() -> None:
    shape = cabinet(0)
    for config in (replace(CONFIG, weights=(0.4, 0.3, 0.2, 0.1)), replace(CONFIG, extra=("symmetry",))):
        with pytest.raises(ValueError, match="meshes"):
            Refiner(shape, config)


def test_extra_candidates_and_the_sweep_term_are_used() -> None:
    shape, meshes = cabinet(0), meshes_of(0)
    config = replace(CONFIG, weights=(0.4, 0.3, 0.2, 0.1), extra=("boxes", "contact", "symmetry"))
    plain, rich = TrueAxes(), TrueAxes()
    Refiner(shape, CONFIG, plain).refine(tree_with_given_bodies(shape, predictions_from_labels(shape)))
    prediction = Refiner(shape, config, rich, meshes).refine(tree_with_given_bodies(shape, predictions_from_labels(shape)))
    assert all(b >= a for a, b in zip(plain.counts, rich.counts, strict=True))
    assert sum(rich.counts) > sum(plain.counts)
    index, _ = next(shape.mobility.movable())
    assert 0.0 <= prediction.estimates[index][0].terms["sweep"] <= 1.0


def test_without_a_selector_the_similarities_decide() -> None:
    shape = cabinet(0)
    prediction = Refiner(shape, CONFIG).refine(tree_with_given_bodies(shape, predictions_from_labels(shape)))
    index, _ = next(shape.mobility.movable())
    assert set(prediction.estimates[index][0].terms) == {"direction", "position"}
    assert max(axis_errors(shape, prediction, refined=True)) < 1e-6
