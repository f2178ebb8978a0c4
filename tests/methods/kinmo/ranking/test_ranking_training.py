"""Training of the ranking networks, from random and from trained weights."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from groupings import grouped_without_network
from small_shapes import cabinet_shape

from kinmo.config import ContinuedConfig, GroupingConfig, Precision, RankingConfig, TrainingConfig
from kinmo.core.errors import InputError
from kinmo.features.candidate_features import CandidateFeatures
from kinmo.features.prepared_shape import PreparedShape
from kinmo.features.shape_preparation import prepare_shape
from kinmo.methods.kinmo.grouping.grouping_training import train_part_grouping
from kinmo.methods.kinmo.ranking.joint_ranker import JointRanker
from kinmo.methods.kinmo.ranking.ranking_training import RankingData, train_joint_ranking
from kinmo.methods.kinmo.ranking.shape_views import ShapeView, view_of_bodies

SCHEDULE = TrainingConfig(epochs=2, learning_rate=1e-3, decay_epochs=0, keep="last")
GROUPING = GroupingConfig(SCHEDULE, width=8, rounds=1, word_features=4)
CONFIG = RankingConfig(
    SCHEDULE, ContinuedConfig(replace(SCHEDULE, epochs=1), batch_views=4), members=2, width=16, word_features=4
)


@pytest.fixture(scope="module")
def shapes() -> list[PreparedShape]:
    return [prepare_shape(cabinet_shape(seed)[0]) for seed in range(4)]


@pytest.fixture(scope="module")
def grouping(shapes: list[PreparedShape], tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("grouping")
    train_part_grouping(shapes[:3], shapes[3:], GROUPING, folder, device="cpu")
    return folder / "weights.safetensors"


@pytest.fixture(scope="module")
def started(shapes: list[PreparedShape], grouping: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("started")
    train_joint_ranking(shapes[:3], shapes[3:], CONFIG, folder, grouping=grouping, device="cpu")
    return folder / "weights.safetensors"


def body_view(shape: PreparedShape) -> ShapeView:
    """The bodies of a shape."""
    features = CandidateFeatures.of(shape.candidate_features)
    return view_of_bodies(grouped_without_network(shape), features, shape.body_leaves)


def parameters(weights: Path) -> torch.Tensor:
    return torch.cat([p.flatten() for p in JointRanker.load(weights, "cpu").networks.parameters()])


def continued(shapes: list[PreparedShape], grouping: Path, start: Path, folder: Path, share: float) -> torch.Tensor:
    config = replace(CONFIG, continued=replace(CONFIG.continued, initial_share=share))
    train_joint_ranking(shapes[:2], shapes[2:], config, folder, grouping=grouping, device="cpu", initial=start)
    return parameters(folder / "weights.safetensors")


@pytest.mark.parametrize("epochs", [1, 9])
def test_few_steps_are_enough_for_a_schedule(shapes, grouping: Path, tmp_path: Path, epochs: int) -> None:
    config = replace(CONFIG, training=replace(SCHEDULE, epochs=epochs), batch_views=64)
    result = train_joint_ranking(shapes[:1], shapes[3:], config, tmp_path, grouping=grouping, device="cpu")
    assert len(result.history) == epochs


def test_mixed_precision_reaches_a_similar_error(shapes, grouping: Path, tmp_path: Path) -> None:
    precisions: tuple[Precision, ...] = ("32-true", "bf16-mixed")
    configs = [replace(CONFIG, training=replace(SCHEDULE, precision=precision)) for precision in precisions]
    exact, mixed = (
        train_joint_ranking(
            shapes[:3], shapes[3:], config, tmp_path / config.training.precision, grouping=grouping, device="cpu"
        ).best_error
        for config in configs
    )
    assert exact != mixed == pytest.approx(exact, rel=0.05)


def test_continued_training_blends_with_the_weights_it_started_from(shapes, grouping, started: Path, tmp_path: Path) -> None:
    start = parameters(started)
    kept, half, gone = (continued(shapes, grouping, started, tmp_path / str(share), share) for share in (1.0, 0.5, 0.0))
    torch.testing.assert_close(kept, start)
    torch.testing.assert_close(half, (start + gone) / 2)
    assert not torch.allclose(gone, start, atol=1e-4)


def test_names_that_training_never_saw_have_no_effect(shapes, started: Path) -> None:
    renamed = replace(shapes[0], part_names=("xylophone",) * len(shapes[0].part_names), category="Quux")
    view = body_view(renamed)
    unknown, hidden = (JointRanker.load(started, "cpu", hide).probabilities(view) for hide in (False, True))
    for found, expected in zip(unknown[0], hidden[0], strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-6)
    known = JointRanker.load(started, "cpu").probabilities(body_view(shapes[0]))
    assert np.abs(known[1] - hidden[1]).max() > 1e-6


def test_networks_trained_without_categories_do_not_depend_on_them(shapes, grouping, started: Path, tmp_path: Path) -> None:
    config = replace(CONFIG, hide_categories=1.0)
    train_joint_ranking(shapes[:3], shapes[3:], config, tmp_path, grouping=grouping, device="cpu")
    named = [replace(shapes[0], category=category) for category in (shapes[0].category, "Quux")]
    views = [body_view(shape) for shape in named]
    for weights, differ in ((tmp_path / "weights.safetensors", False), (started, True)):
        ranking = JointRanker.load(weights, "cpu")
        known, renamed = (ranking.probabilities(view)[1] for view in views)
        assert bool(np.abs(known - renamed).max() > 1e-6) is differ


def test_weights_of_other_sizes_are_refused_as_a_start(shapes, grouping, started: Path, tmp_path: Path) -> None:
    options = {"grouping": grouping, "device": "cpu", "initial": started}
    with pytest.raises(InputError, match=r"weights\.safetensors"):
        train_joint_ranking(shapes[:2], shapes[2:], replace(CONFIG, width=24), tmp_path, **options)


def test_batches_hold_views_of_similar_size_and_every_view_once(shapes) -> None:
    view = body_view(shapes[0])
    sizes = [1, 2] * CONFIG.batch_views
    views = [replace(view, groups=view.groups[:n], words=view.words[:n], context=view.context[:n]) for n in sizes]
    views = [replace(each, targets=view.targets[:n], weights=view.weights[:n]) for each, n in zip(views, sizes, strict=True)]
    data = RankingData(views, views, CONFIG)
    batches = list(data.training_batches(0, np.random.default_rng(0)))
    assert len(batches) == data.steps == 2
    found = [torch.bincount(batch.view_of).tolist() for batch in batches]
    assert all(len(set(own)) == 1 for own in found)
    assert sorted(size for own in found for size in own) == sorted(sizes)


def test_shapes_without_joints_are_refused(shapes, grouping: Path, tmp_path: Path) -> None:
    bare = [replace(shape, mobility=None) for shape in shapes]
    with pytest.raises(InputError, match="validation shapes"):
        train_joint_ranking(shapes[:2], bare, CONFIG, tmp_path, grouping=grouping, device="cpu")
