"""Targets, batches and the ranking network."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from cabinet_geometry import DOOR, DRAWER, FRAME, KNOB, UP, cabinet_geometry

from kinmo.core.joint import Joint, JointKind
from kinmo.features.candidate_features import compute_candidate_features
from kinmo.methods.kinmo.ranking.name_words import hash_words
from kinmo.methods.kinmo.ranking.ranking_batches import collate_views
from kinmo.methods.kinmo.ranking.ranking_network import RankingNetwork, group_log_softmax, ranking_loss
from kinmo.methods.kinmo.ranking.shape_views import ShapeView, soft_target

FEATURES = compute_candidate_features(cabinet_geometry(), [(FRAME,), (DOOR,), (KNOB,), (DRAWER,)])
HINGE = Joint(JointKind.REVOLUTE, UP, np.array([-0.23, 0.0, 0.155]))
SLIDE = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3))


def cabinet_view() -> ShapeView:
    """The four leaves of the cabinet, two of which move."""
    words = tuple(tuple(hash_words("part", word)) for word in ("frame", "door", "knob", "drawer"))
    targets = [np.zeros(count) for count in FEATURES.counts(range(4))]
    targets[1], targets[3] = soft_target(FEATURES, 1, HINGE), soft_target(FEATURES, 3, SLIDE)
    return ShapeView(FEATURES, (0, 1, 2, 3), np.zeros((4, 2), np.float32), words, (), tuple(targets), np.ones(4))


def small_network() -> RankingNetwork:
    torch.manual_seed(0)
    batch = collate_views([cabinet_view()])
    network = RankingNetwork(batch.candidates.shape[1], batch.groups.shape[1], width=32)
    network.standardize(batch.candidates, batch.groups)
    return network.eval()


def test_a_target_is_highest_for_the_nearest_axis_of_the_true_kind() -> None:
    wanted = soft_target(FEATURES, 1, HINGE)
    assert wanted.sum() == pytest.approx(1.0)
    rows = FEATURES.rows(1)
    best = int(np.argmax(wanted))
    assert FEATURES.kinds[rows][best] == JointKind.REVOLUTE.code
    assert not wanted[FEATURES.kinds[rows] != JointKind.REVOLUTE.code].any()
    assert np.linalg.norm((FEATURES.pivots[rows][best] - HINGE.pivot)[[0, 2]]) < 0.03


def test_a_target_does_not_depend_on_the_sense_of_the_axis() -> None:
    np.testing.assert_allclose(soft_target(FEATURES, 1, HINGE.reversed()), soft_target(FEATURES, 1, HINGE))


def test_probabilities_of_candidates_and_rest_sum_to_one() -> None:
    scores, rest = torch.randn(7), torch.randn(3)
    group_of = torch.tensor([0, 0, 0, 1, 1, 2, 2])
    candidates, still = group_log_softmax(scores, rest, group_of)
    total = still.exp().index_add(0, group_of, candidates.exp())
    torch.testing.assert_close(total, torch.ones(3))


@torch.no_grad()
def test_a_shape_has_the_same_probabilities_alone_and_in_a_batch() -> None:
    network = small_network()
    alone = network(collate_views([cabinet_view()]))
    both = network(collate_views([cabinet_view(), cabinet_view()]))
    count = len(alone[0])
    for part in (both[0][:count], both[0][count:]):
        torch.testing.assert_close(part, alone[0], atol=1e-4, rtol=1e-4)
    torch.testing.assert_close(both[1][:4], alone[1], atol=1e-4, rtol=1e-4)


def test_hidden_names_leave_no_words() -> None:
    assert len(collate_views([cabinet_view()]).words) == 4
    assert len(collate_views([cabinet_view()], hide_names=True).words) == 0
    assert len(collate_views([cabinet_view()], rng=np.random.default_rng(0), hide_group=1.0).words) == 0


def test_a_category_is_hidden_independently_of_the_names_of_parts() -> None:
    known = replace(cabinet_view(), category=tuple(hash_words("category", "cabinet")))
    parts, both = len(collate_views([cabinet_view()]).words), len(collate_views([known]).words)
    assert both == parts + len(known.groups)
    assert len(collate_views([known], hide_category=1.0).words) == parts
    assert len(collate_views([known], hide_category=0.5).words) == both, "nothing is hidden at random without a generator"
    rng = np.random.default_rng(0)
    assert {len(collate_views([known], rng=rng, hide_category=0.5).words) for _ in range(20)} == {parts, both}


@torch.no_grad()
def test_an_unknown_word_is_no_error() -> None:
    words = (tuple(hash_words("part", "Schubladenfront 7 Ünïcode")), (), (), ())
    assert torch.isfinite(small_network()(collate_views([replace(cabinet_view(), words=words)]))[1]).all()


def test_training_learns_the_cabinet() -> None:
    network = small_network().train()
    optimizer = torch.optim.Adam(network.parameters(), lr=3e-3)
    batch = collate_views([cabinet_view()])
    losses = []
    for _ in range(40):
        loss = ranking_loss(*network(batch), batch)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        losses.append(loss.item())
    assert losses[-1] < 0.5 * losses[0]
