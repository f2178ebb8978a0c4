"""Boosted trees on candidate features, as a baseline."""

from __future__ import annotations

import numpy as np
import pytest
from articulated import shape_of_boxes

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from kinmo.core.motion_types import CoarseType, MotionType
from kinmo.evaluation.joint_records import ShapeScore
from kinmo.evaluation.parts_given import score_parts_given
from kinmo.experiments.table1.trees_baseline import KIND_LEAVES, TreesBaseline, classifier, fit_trees, probabilities
from kinmo.features.prepared_shape import PreparedShape
from kinmo.features.shape_preparation import prepare_shape

SIDEWAYS, FRONT = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


def cabinet(seed: int) -> PreparedShape:
    """A carcass of any size with a flap in front, hinged at its top, and a drawer below it."""
    width, height, depth = np.random.default_rng(seed).uniform(0.8, 1.2, 3)
    boxes = [
        ((0, 0, 0), (width, height, depth)),
        ((0, 0.4 * height, depth), (width, height, depth + 0.03)),
        ((0, 0, 0.2 * depth), (width, 0.38 * height, depth + 0.03)),
    ]
    hinge = Joint(JointKind.REVOLUTE, SIDEWAYS, np.array([0, height, depth]), 0.0, 1.5)
    slide = Joint(JointKind.PRISMATIC, FRONT, np.zeros(3), 0.0, 0.5)
    bodies = (Body(0, "carcass", (1,)), Body(1, "flap", (2,), 0, hinge), Body(2, "drawer", (3,), 0, slide))
    return prepare_shape(shape_of_boxes(boxes, bodies, shape_id=str(seed)), points=128)


@pytest.fixture(scope="module")
def trees() -> TreesBaseline:
    return fit_trees(cabinet(seed) for seed in range(24))


def score(trees: TreesBaseline, seed: int, *, kinds_given: bool = False) -> ShapeScore:
    truth = cabinet(seed)
    return score_parts_given(truth, trees.predict(truth, kinds_given=kinds_given))


def test_trees_learn_the_part_that_turns_and_its_axis(trees):
    scores = [score(trees, seed) for seed in range(100, 106)]
    assert np.mean([record.is_ok for own in scores for record in own.records]) > 0.8
    assert not any(own.false_alarms for own in scores)


def test_with_given_kinds_all_kinds_are_right(trees):
    for seed in range(100, 103):
        assert all(record.coarse_type_ok for record in score(trees, seed, kinds_given=True).records)


def test_every_body_has_an_estimate_and_a_resting_one_has_no_joint(trees):
    found = trees.predict(cabinet(100))
    assert set(found) == {0, 1, 2}
    for estimate in found.values():
        assert (estimate.joint is None) == (estimate.type is MotionType.FIXED)
        assert 0.0 <= estimate.score <= 1.0


def test_a_class_that_was_never_seen_has_no_probability():
    rng = np.random.default_rng(0)
    features = rng.normal(size=(480, 5)) + 6.0 * (np.arange(480)[:, None] % 8 == 0) * [1, 0, 0, 0, 0]
    kinds = np.where(features[:, 0] > 3.0, CoarseType.R, CoarseType.FIXED)
    model = classifier(0, KIND_LEAVES, iterations=30).fit(features[:320], kinds[:320])
    found = probabilities(model, features[320:], len(CoarseType))
    assert np.mean(found.argmax(axis=1) == kinds[320:]) > 0.95
    assert np.all(found[:, CoarseType.PR] == 0)
