"""Training of the motion GNN and of the axis selection network on a handful of shapes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from small_shapes import cabinet

from kinmo.config import load_config
from kinmo.core.errors import InputError
from kinmo.core.motion_types import CoarseType, MotionType
from kinmo.learning.motion_gnn.gnn_predictor import MotionGnnPredictor
from kinmo.learning.motion_gnn.gnn_training import train_motion_gnn
from kinmo.methods.paper.axis_selection.axis_selection_training import train_axis_selection
from kinmo.methods.paper.axis_selection.axis_selector import AxisSelector
from kinmo.methods.paper.candidate_axes import candidate_axes
from kinmo.methods.paper.leaf_roles import leaf_roles

SMALL, PAPER = load_config("small"), load_config("paper")


@pytest.fixture(scope="module")
def predictor(tmp_path_factory: pytest.TempPathFactory) -> MotionGnnPredictor:
    folder = tmp_path_factory.mktemp("gnn")
    config = replace(SMALL.gnn, training=replace(SMALL.gnn.training, epochs=20), batch_shapes=6)
    shapes = [cabinet(seed) for seed in range(36)]
    result = train_motion_gnn(shapes[:30], shapes[30:], config, folder, device="cpu")
    assert result.history[-1]["training/loss"] < 0.4 * result.history[0]["training/loss"]
    return MotionGnnPredictor.load(folder / "weights.safetensors", "cpu")


def test_the_motion_gnn_predicts_types_of_unseen_shapes(predictor: MotionGnnPredictor) -> None:
    shapes = [cabinet(seed) for seed in range(100, 110)]
    found = predictor.predict_many(shapes)
    right = np.concatenate([f.types == s.edge_labels.types for f, s in zip(found, shapes, strict=True)])
    assert right.mean() > 0.9


def test_predictions_are_unit_vectors_and_probabilities(predictor: MotionGnnPredictor) -> None:
    found = predictor.predict_edges(cabinet(100))
    np.testing.assert_allclose(np.linalg.norm(found.directions, axis=1), 1)
    np.testing.assert_allclose(found.type_probabilities.sum(axis=1), 1)
    assert found.type_set is MotionType


def test_hidden_names_do_not_change_predictions(predictor: MotionGnnPredictor) -> None:
    blind = MotionGnnPredictor(predictor.network, predictor.config, "cpu", hide_names=True)
    shape = cabinet(100)
    renamed = replace(shape, part_names=tuple("other" for _ in shape.part_names))
    np.testing.assert_array_equal(
        blind.predict_edges(shape).type_probabilities, blind.predict_edges(renamed).type_probabilities
    )
    assert not np.allclose(
        predictor.predict_edges(shape).type_probabilities, predictor.predict_edges(renamed).type_probabilities
    )


@pytest.mark.parametrize("role", ["training", "validation"])
def test_without_an_edge_to_learn_from_the_message_names_the_shapes(role: str, tmp_path: Path) -> None:
    shapes = {"training": [cabinet(0)], "validation": [cabinet(1)]}
    config = replace(SMALL.gnn, edges="contact", contact=0.5)
    shapes[role] = [replace(shape, edge_distances=np.ones_like(shape.edge_distances)) for shape in shapes[role]]
    with pytest.raises(InputError, match=f"^{role} shapes: expected a shape with two parts in contact"):
        train_motion_gnn(shapes["training"], shapes["validation"], config, tmp_path, device="cpu")


def test_edges_without_contact_are_none_for_a_contact_network(tmp_path: Path) -> None:
    config = replace(SMALL.gnn, edges="contact", contact=0.01, training=replace(SMALL.gnn.training, epochs=1))
    shapes = [cabinet(seed) for seed in range(4)]
    train_motion_gnn(shapes[:3], shapes[3:], config, tmp_path, types="coarse", device="cpu")
    shape = next(s for s in map(cabinet, range(100)) if (s.edge_distances > 0.01).any())
    found = MotionGnnPredictor.load(tmp_path / "weights.safetensors", "cpu").predict_edges(shape)
    assert found.type_set is CoarseType
    assert (found.types[shape.edge_distances > 0.01] == CoarseType.NONE).all()


def test_axis_selection_ranks_a_true_hinge_above_the_other_axes(tmp_path: Path) -> None:
    config = replace(
        SMALL.axis,
        training=replace(SMALL.axis.training, epochs=6),
        encoder=replace(SMALL.axis.encoder, points=64),
        batch_joints=12,
        batches_per_epoch=20,
    )
    shapes = [cabinet(seed) for seed in range(40)]
    result = train_axis_selection(shapes[:34], shapes[34:], config, tmp_path, device="cpu")
    assert max(row["validation/ranked_right"] for row in result.history) > 0.65
    selector = AxisSelector.load(tmp_path / "weights.safetensors", "cpu")
    shape = cabinet(200)
    body, _ = next(shape.mobility.movable())
    candidates = candidate_axes(shape.body_types[body], shape.body_boxes[body], shape.up)
    # scores are kept for the same shape, and computed again for an equal one
    moving = leaf_roles(shape, shape.mobility.bodies)[body].moving
    scores = [selector.feasibility(seen, moving, candidates) for seen in (shape, shape, replace(shape))]
    np.testing.assert_array_equal(scores[0], scores[1])
    np.testing.assert_array_equal(scores[0], scores[2])
    assert ((scores[0] >= 0) & (scores[0] <= 1)).all()


def test_training_starts_from_initial_weights(tmp_path: Path) -> None:
    shapes = [cabinet(seed) for seed in range(4)]
    still = {"epochs": 1, "learning_rate": 0.0}
    gnn = replace(SMALL.gnn, variants=0, training=replace(SMALL.gnn.training, **still))
    encoder = replace(SMALL.axis.encoder, points=64, norm="group")
    axis = replace(SMALL.axis, encoder=encoder, batches_per_epoch=1, training=replace(SMALL.axis.training, **still))
    for train, config in ((train_motion_gnn, gnn), (train_axis_selection, axis)):
        first, second, other = (tmp_path / train.__name__ / name for name in ("first", "second", "other"))
        train(shapes[:3], shapes[3:], config, first, device="cpu", seed=1)
        train(shapes[:3], shapes[3:], config, second, device="cpu", seed=2, initial=first / "weights.safetensors")
        train(shapes[:3], shapes[3:], config, other, device="cpu", seed=2)
        contents = [(folder / "weights.safetensors").read_bytes() for folder in (first, second, other)]
        assert contents[0] == contents[1] != contents[2]


def test_two_steps_of_the_papers_sizes_run(tmp_path: Path) -> None:
    """The networks have the paper's layers; fewer points are enough to run them."""
    leaf = replace(PAPER.gnn.leaf, points=64)
    gnn = replace(PAPER.gnn, training=replace(PAPER.gnn.training, epochs=1), batch_shapes=1, leaf=leaf)
    shapes = [cabinet(seed) for seed in range(3)]
    result = train_motion_gnn(shapes[:2], shapes[2:], gnn, tmp_path / "gnn", device="cpu")
    assert np.isfinite(result.best_error)
    axis = replace(
        PAPER.axis,
        training=replace(PAPER.axis.training, epochs=1),
        encoder=replace(PAPER.axis.encoder, points=128),
        batch_joints=1,
        batches_per_epoch=2,
    )
    result = train_axis_selection(shapes[:2], shapes[2:], axis, tmp_path / "axis", device="cpu")
    assert np.isfinite(result.best_error)
