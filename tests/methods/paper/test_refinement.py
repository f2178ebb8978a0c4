from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from edge_predictions import told
from small_shapes import cabinet, cabinet_shape

from kinmo import _core
from kinmo.config import RefinementConfig
from kinmo.core.joint import CoarseType, JointKind, MotionType
from kinmo.core.normalisation import Normalisation
from kinmo.core.prediction import Prediction
from kinmo.features.candidate_joints import Candidates
from kinmo.features.part_geometry import interaction_centroid, part_geometries, symmetric_box
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions
from kinmo.methods.paper.mobility_tree import given_tree, predicted_tree
from kinmo.methods.paper.refinement import Refiner

CONFIG = RefinementConfig()


def leaf_meshes(seed: int) -> _core.Meshes:
    shape, _ = cabinet_shape(seed)
    frame = Normalisation.of(shape)
    meshes = [frame.mesh(mesh) for mesh in shape.meshes()]
    return _core.Meshes([mesh.vertices for mesh in meshes], [mesh.faces for mesh in meshes])


def blurred(shape: PreparedShape, seed: int = 0) -> EdgePredictions:
    """Right types, and axes that are off by some ten degrees and a twentieth of the diagonal."""
    said = told(shape)
    rng = np.random.default_rng(seed)
    directions = said.directions + rng.normal(size=said.directions.shape) * 0.12
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return replace(said, directions=directions, pivots=said.pivots + rng.normal(size=said.pivots.shape) * 0.03)


class TrueAxes:
    """Feasibility one for candidates near the true joint of the moving leaves, zero for others."""

    def __init__(self) -> None:
        self.asked: list[int] = []

    def score_candidates(self, shape: PreparedShape, moving: list[int], candidates: Candidates) -> np.ndarray:
        self.asked.append(len(candidates))
        leaves = {shape.leaves[place] for place in moving}
        joint = next(body.joint for body in shape.mobility.bodies if set(body.leaves) <= leaves and body.joint is not None)
        parallel = np.abs(candidates.directions @ joint.direction) > 0.999
        across = np.linalg.norm(np.cross(candidates.pivots - joint.pivot, joint.direction), axis=1)
        return np.where(parallel & ((across < 0.03) | (joint.kind is JointKind.PRISMATIC)), 1.0, 0.0)


def axis_errors(shape: PreparedShape, prediction: Prediction, refined: bool) -> list[float]:
    """Degrees between true and found axes, per movable body."""
    errors = []
    for index, body in shape.mobility.movable():
        found = prediction.mobility.bodies[index].joint if refined else prediction.network_estimates[index].joint
        errors.append(np.degrees(np.arccos(min(1.0, abs(found.direction @ body.joint.direction)))))
    return errors


@pytest.mark.parametrize("seed", range(4))
def test_refined_axes_are_those_of_the_box_and_better_than_the_networks(seed: int) -> None:
    shape = cabinet(seed)
    selector = TrueAxes()
    prediction = Refiner(shape, CONFIG, selector).refine(given_tree(shape, blurred(shape)))
    assert max(axis_errors(shape, prediction, refined=True)) < 1e-6
    assert min(axis_errors(shape, prediction, refined=False)) > 0.5
    expected = {MotionType.P_H: 2, MotionType.R_V_S: 4}
    assert selector.asked == [expected[shape.body_types[i]] for i, _ in shape.mobility.movable()]


@pytest.mark.parametrize("seed", range(4))
def test_answers_are_in_the_shapes_own_frame(seed: int) -> None:
    shape = cabinet(seed)
    truth, _ = cabinet_shape(seed)
    prediction = Refiner(shape, CONFIG, TrueAxes()).refine(given_tree(shape, told(shape)))
    for index, body in truth.mobility.movable():
        found = prediction.mobility.bodies[index].joint
        assert found.kind is body.joint.kind
        if found.has_pivot:
            across = np.linalg.norm(np.cross(found.pivot - body.joint.pivot, body.joint.direction))
            assert across < 0.05 * truth.diagonal
            own = prediction.network_estimates[index].joint
            np.testing.assert_allclose(np.cross(own.pivot - body.joint.pivot, body.joint.direction), 0, atol=1e-9)


def test_answers_are_ranked_and_say_what_they_are_made_of() -> None:
    shape = cabinet(0)
    prediction = Refiner(shape, CONFIG, TrueAxes()).refine(given_tree(shape, blurred(shape)))
    for index, _ in shape.mobility.movable():
        answers = prediction.estimates[index]
        assert [a.score for a in answers] == sorted((a.score for a in answers), reverse=True)
        assert set(answers[0].terms) == {"feasibility", "direction", "position"}
        assert answers[0].source == ("box edge" if answers[0].joint.kind is JointKind.REVOLUTE else "box centre")
        assert answers[0].joint is prediction.mobility.bodies[index].joint
    assert prediction.estimates[0][0].joint is None


def test_directions_point_to_the_networks_side() -> None:
    shape = cabinet(1)
    said = blurred(shape)
    for sense in (1.0, -1.0):
        turned = replace(said, directions=sense * said.directions)
        prediction = Refiner(shape, CONFIG, TrueAxes()).refine(given_tree(shape, turned))
        for index, body in shape.mobility.movable():
            assert sense * (prediction.mobility.bodies[index].joint.direction @ body.joint.direction) > 0.9


def test_coarse_types_are_refined_from_all_axes_of_the_box() -> None:
    shape = cabinet(0)
    fine = blurred(shape)
    coarse = np.zeros((len(shape.edges), 5))
    for motion in MotionType:
        coarse[:, motion.coarse] += fine.type_probabilities[:, motion]
    selector = TrueAxes()
    prediction = Refiner(shape, CONFIG, selector).refine(given_tree(shape, replace(fine, type_probabilities=coarse)))
    assert set(selector.asked) <= {3, 15}
    assert all(isinstance(answers[0].type, CoarseType) for answers in prediction.estimates[1:])


@pytest.mark.parametrize("seed", range(4))
def test_drawers_are_let_out_to_the_front_alone(seed: int) -> None:
    shape = cabinet(seed)
    meshes = leaf_meshes(seed)
    prediction = Refiner(shape, CONFIG, TrueAxes(), meshes).refine(predicted_tree(shape, told(shape)))
    for body in prediction.mobility.bodies:
        if body.joint is not None:
            assert body.joint.lower <= 0 <= body.joint.upper
            if body.joint.kind is JointKind.PRISMATIC:
                assert body.joint.lower == 0.0
                assert body.joint.upper > 0.1 * shape.diagonal


def test_the_swept_term_and_extra_candidates_need_meshes() -> None:
    shape = cabinet(0)
    for config in (replace(CONFIG, weights=(0.4, 0.3, 0.2, 0.1)), replace(CONFIG, extra=("symmetry",))):
        with pytest.raises(ValueError, match="meshes"):
            Refiner(shape, config)


def test_extra_candidates_and_the_swept_term_take_part() -> None:
    shape, meshes = cabinet(0), leaf_meshes(0)
    config = replace(CONFIG, weights=(0.4, 0.3, 0.2, 0.1), extra=("boxes", "contact", "symmetry"))
    plain, rich = TrueAxes(), TrueAxes()
    Refiner(shape, CONFIG, plain).refine(given_tree(shape, told(shape)))
    prediction = Refiner(shape, config, rich, meshes).refine(given_tree(shape, told(shape)))
    assert all(b >= a for a, b in zip(plain.asked, rich.asked, strict=True))
    assert sum(rich.asked) > sum(plain.asked)
    index, _ = next(shape.mobility.movable())
    assert 0.0 <= prediction.estimates[index][0].terms["sweep"] <= 1.0


def test_without_a_selector_consistency_decides() -> None:
    shape = cabinet(0)
    prediction = Refiner(shape, CONFIG).refine(given_tree(shape, told(shape)))
    index, _ = next(shape.mobility.movable())
    assert set(prediction.estimates[index][0].terms) == {"direction", "position"}
    assert max(axis_errors(shape, prediction, refined=True)) < 1e-6


def test_boxes_of_groups_are_those_of_parts_bodies_or_their_own() -> None:
    shape = cabinet(3)
    part = next(i for i, below in enumerate(shape.leaves_below) if len(below) == 2)
    assert symmetric_box(shape, shape.leaves_below[part]).center is not None
    np.testing.assert_array_equal(symmetric_box(shape, shape.leaves_below[part]).center, shape.symmetric_boxes.centers[part])
    mixed = [0, len(shape.leaves) - 1]
    fitted, exact = symmetric_box(shape, mixed), symmetric_box(shape, mixed, leaf_meshes(3))
    assert exact.volume * 0.7 < fitted.volume <= exact.volume * 1.001


def test_interaction_regions_lie_between_the_parts() -> None:
    shape = cabinet(0)
    tree = given_tree(shape, told(shape))
    for index, part in enumerate(part_geometries(shape, tree.bodies)):
        if tree.bodies[index].parent is not None:
            centroid = interaction_centroid(shape, part)
            own = shape.leaf_points[part.leaves].reshape(-1, 3)
            assert (centroid >= own.min(axis=0) - 0.02).all()
            assert (centroid <= own.max(axis=0) + 0.02).all()
    assert interaction_centroid(shape, replace(part, reference=[])) is None
