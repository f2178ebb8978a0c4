"""Examples, training and predictions of the limits network."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from small_shapes import cabinet_shape

from kinmo.config import LimitsConfig, TrainingConfig
from kinmo.core.errors import InputError
from kinmo.features.prepared_shape import leaf_meshes
from kinmo.features.shape_preparation import prepare_shape
from kinmo.methods.kinmo.limits.limits_network import STEPS, LimitsNetwork, likely_travel, limits_loss
from kinmo.methods.kinmo.limits.limits_predictor import LimitsPredictor
from kinmo.methods.kinmo.limits.limits_training import train_joint_limits
from kinmo.methods.kinmo.limits.travel_examples import UNLIMITED, TravelExamples, examples_of, joined, read_examples, to_bytes

CONFIG = LimitsConfig(
    TrainingConfig(epochs=40, learning_rate=1e-2, decay_epochs=0, keep="last", threads=1),
    TrainingConfig(epochs=1, learning_rate=1e-3, decay_epochs=0, keep="last", threads=1),
    width=24,
    word_features=4,
    dropout=0.0,
    batch_joints=8,
)


@pytest.fixture(scope="module")
def examples() -> list[TravelExamples]:
    found = []
    for seed in range(8):
        shape = cabinet_shape(seed)[0]
        prepared = prepare_shape(shape, points=64)
        example = examples_of(prepared, leaf_meshes(shape, prepared))
        assert example is not None
        found.append(example)
    return found


@pytest.fixture(scope="module")
def weights(examples: list[TravelExamples], tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("limits")
    train_joint_limits(examples[:6], examples[6:], CONFIG, folder, device="cpu")
    return folder / "weights.safetensors"


def turned_around(examples: TravelExamples) -> TravelExamples:
    """The same joints with opposite directions."""
    return replace(examples, directed=examples.directed[:, ::-1].copy(), travel=examples.travel[:, ::-1].copy())


def test_training_learns_the_limits_of_cabinets(examples, weights: Path) -> None:
    known = joined(examples[:6])
    travel, is_limited = LimitsPredictor.load(weights, "cpu").travel(known)
    assert is_limited.all()
    overlap = np.minimum(travel, known.travel).sum(axis=1) / np.maximum(travel, known.travel).sum(axis=1)
    assert overlap.mean() > 0.8


def test_a_joint_with_the_opposite_direction_has_exchanged_limits(examples, weights: Path) -> None:
    predictor = LimitsPredictor.load(weights, "cpu")
    one, other = predictor.travel(examples[0]), predictor.travel(turned_around(examples[0]))
    np.testing.assert_allclose(one[0], other[0][:, ::-1])
    np.testing.assert_array_equal(one[1], other[1])


def test_hidden_names_have_no_effect(examples, weights: Path) -> None:
    renamed = replace(examples[0], words=examples[0].words[:, ::-1].copy())
    hidden = LimitsPredictor.load(weights, "cpu", hide_names=True)
    np.testing.assert_array_equal(hidden.travel(examples[0])[0], hidden.travel(renamed)[0])


def test_training_continues_from_weights(examples, weights: Path, tmp_path: Path) -> None:
    train_joint_limits(examples[:6], examples[6:], CONFIG, tmp_path, device="cpu", initial=weights)
    travel = [LimitsPredictor.load(path, "cpu").travel(examples[7])[0] for path in (weights, tmp_path / "weights.safetensors")]
    assert np.abs(travel[0] - travel[1]).mean() < 0.2


def test_the_loss_is_least_for_the_true_limits() -> None:
    true = torch.tensor([[1.0, 0.0], [UNLIMITED, UNLIMITED]])
    right = torch.full((2, 2, len(STEPS)), -20.0)
    right[0, 0, STEPS.index(1.0)] = right[0, 1, 0] = 0.0
    wrong = right.flip(1)
    limited = torch.tensor([20.0, -20.0])
    assert limits_loss(right, limited, true) < 1e-4 < limits_loss(wrong, limited, true)
    assert limits_loss(right, -limited, true) > 1.0


@given(st.integers(0, len(STEPS) - 1), st.integers(0, len(STEPS) - 1))
def test_sure_probabilities_give_that_travel(first: int, second: int) -> None:
    probabilities = np.zeros((1, 2, len(STEPS)))
    probabilities[0, 0, first] = probabilities[0, 1, second] = 1.0
    ((forward, backward),) = likely_travel(probabilities)
    if first or second:
        assert (forward, backward) == (STEPS[first], STEPS[second])
    else:
        assert forward + backward > 0, "a joint moves"


def test_examples_are_read_as_they_were_written(examples, tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(to_bytes(examples[0]))
    found = read_examples(tmp_path / "a")
    for field in fields(TravelExamples):
        np.testing.assert_array_equal(getattr(found, field.name), getattr(examples[0], field.name))
    (tmp_path / "a").write_bytes(b"damaged")
    with pytest.raises(InputError, match="not examples of joint limits"):
        read_examples(tmp_path / "a")


def test_training_needs_joints(examples, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="at least one annotated joint"):
        train_joint_limits(examples, [], CONFIG, tmp_path, device="cpu")


def test_a_word_that_training_never_saw_has_no_effect() -> None:
    network = LimitsNetwork(2, 3, CONFIG).eval()
    network.silence_unknown_words(torch.tensor([5]))
    inputs = torch.zeros(1, 2, 2), torch.zeros(1, 3)
    nothing, known, unknown = (network(*inputs, torch.tensor([[word, -1]]))[0] for word in (-1, 5, 6))
    assert torch.equal(nothing, unknown) and not torch.equal(nothing, known)
