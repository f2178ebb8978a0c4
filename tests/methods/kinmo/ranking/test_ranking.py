"""Targets, batches, the network and its answers."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from evidence_cabinet import DOOR, DRAWER, FRAME, KNOB, UP, scene

from kinmo.core.box import Box
from kinmo.core.joint import Joint, JointKind
from kinmo.features.candidate_features import REVOLUTE, Evidence, gather
from kinmo.methods.kinmo.ranking.ranked_joints import agreement, rank_answers
from kinmo.methods.kinmo.ranking.ranking_batches import View, collate, hash_words, hypothesis_costs, soft_target
from kinmo.methods.kinmo.ranking.ranking_network import JointRanker, ranking_loss, segment_log_softmax

EVIDENCE = gather(scene(), [(FRAME,), (DOOR,), (KNOB,), (DRAWER,)])
HINGE = Joint(JointKind.REVOLUTE, UP, np.array([-0.23, 0.0, 0.155]))
SLIDE = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3))


def target(unit: int, joint: Joint | None) -> np.ndarray | None:
    return (
        None if joint is None else soft_target(hypothesis_costs(EVIDENCE, EVIDENCE.rows(unit), joint, EVIDENCE.centers[unit]))
    )


def view(name: str = "cabinet") -> View:
    targets = (None, target(1, HINGE), None, target(3, SLIDE))
    words = tuple(tuple(hash_words("part", word)) for word in ("frame", "door", "knob", "drawer"))
    return View(name, EVIDENCE, (0, 1, 2, 3), True, words, targets)


def network() -> JointRanker:
    torch.manual_seed(0)
    batch = collate([view()])
    ranker = JointRanker(batch.hypotheses.shape[1], batch.units.shape[1], width=32)
    ranker.standardize(batch.hypotheses, batch.units)
    return ranker.eval()


def test_a_target_prefers_the_nearest_axis_of_the_right_kind() -> None:
    wanted = target(1, HINGE)
    assert wanted is not None
    assert wanted.sum() == pytest.approx(1.0)
    rows = EVIDENCE.rows(1)
    best = int(np.argmax(wanted))
    assert EVIDENCE.kinds[rows][best] == REVOLUTE
    assert not wanted[EVIDENCE.kinds[rows] != REVOLUTE].any()
    assert np.linalg.norm((EVIDENCE.pivots[rows][best] - HINGE.pivot)[[0, 2]]) < 0.03


def test_a_target_does_not_know_the_sense_of_an_axis() -> None:
    np.testing.assert_allclose(target(1, HINGE.reversed()), target(1, HINGE))


def test_hypotheses_and_rest_share_one_probability() -> None:
    scores, rest = torch.randn(7), torch.randn(3)
    unit_of = torch.tensor([0, 0, 0, 1, 1, 2, 2])
    hypotheses, still = segment_log_softmax(scores, rest, unit_of)
    total = still.exp().index_add(0, unit_of, hypotheses.exp())
    torch.testing.assert_close(total, torch.ones(3))


@torch.no_grad()
def test_a_shape_is_answered_alike_alone_and_in_a_batch() -> None:
    ranker = network()
    alone = ranker(collate([view()]))
    both = ranker(collate([view("first"), view("second")]))
    count = len(alone[0])
    for part in (both[0][:count], both[0][count:]):
        torch.testing.assert_close(part, alone[0], atol=1e-4, rtol=1e-4)
    torch.testing.assert_close(both[1][:4], alone[1], atol=1e-4, rtol=1e-4)


def test_hidden_names_leave_no_word() -> None:
    assert len(collate([view()]).words) == 4
    assert len(collate([view()], hide_names=True).words) == 0
    assert len(collate([view()], rng=np.random.default_rng(0), hide_view=1.0).words) == 0


def test_a_category_is_hidden_apart_from_the_parts_names() -> None:
    known = replace(view(), category=tuple(hash_words("category", "cabinet")))
    parts, both = len(collate([view()]).words), len(collate([known]).words)
    assert both == parts + len(known.units)
    assert len(collate([known], hide_category=1.0).words) == parts
    assert len(collate([known], hide_category=0.5).words) == both, "without a source of chance nothing is hidden by chance"
    rng = np.random.default_rng(0)
    assert {len(collate([known], rng=rng, hide_category=0.5).words) for _ in range(20)} == {parts, both}


@torch.no_grad()
def test_a_word_never_seen_is_no_error() -> None:
    strange = View("x", EVIDENCE, (1,), True, (tuple(hash_words("part", "Schubladenfront 7 Ünïcode")),), (None,))
    assert torch.isfinite(network()(collate([strange]))[1]).all()


def test_training_learns_the_cabinet() -> None:
    ranker = network().train()
    optimizer = torch.optim.Adam(ranker.parameters(), lr=3e-3)
    batch = collate([view()])
    first = last = 0.0
    for step in range(40):
        loss = ranking_loss(*ranker(batch), batch)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        first, last = (loss.item(), last) if step == 0 else (first, loss.item())
    assert last < 0.5 * first


def answers(unit: int, best: int, sure: float, rest: float, evidence: Evidence = EVIDENCE):  # type: ignore[no-untyped-def]
    rows = evidence.rows(unit)
    probabilities = np.full(rows.stop - rows.start, (1 - rest - sure) / (rows.stop - rows.start - 1))
    probabilities[best] = sure
    box = Box(evidence.centers[unit], np.eye(3), np.array([0.23, 0.2, 0.01]))
    return rank_answers(evidence, unit, probabilities, rest, box, UP)


def test_the_surest_axis_is_answered_and_runners_up_differ_from_it() -> None:
    best = int(np.argmax(target(1, HINGE)))
    found = answers(1, best, 0.7, 0.1)
    assert found[0].joint is not None
    np.testing.assert_allclose(found[0].joint.pivot, EVIDENCE.pivots[EVIDENCE.rows(1)][best])
    assert found[0].type.name == "R_V_S"
    assert 0.7 <= found[0].score <= 1.0
    assert found[-1].joint is None
    joints = [answer.joint for answer in found if answer.joint is not None]
    kinds = np.array([list(JointKind).index(joint.kind) for joint in joints])
    agree = agreement(kinds, np.array([j.direction for j in joints]), np.array([j.pivot for j in joints]))
    assert agree.sum() == len(joints)


def test_doubtful_hinges_along_one_direction_outweigh_a_single_one_that_lies_across() -> None:
    rows = EVIDENCE.rows(1)
    turning = EVIDENCE.kinds[rows] == REVOLUTE
    upright = turning & (np.abs(EVIDENCE.directions[rows] @ UP) > 0.999)
    edges = np.flatnonzero(upright)[[0, -1]]
    across = int(np.flatnonzero(turning & (np.abs(EVIDENCE.directions[rows] @ UP) < 0.1))[0])
    assert not agreement(EVIDENCE.kinds[rows], EVIDENCE.directions[rows], EVIDENCE.pivots[rows])[edges[0], edges[1]]
    probabilities = np.zeros(rows.stop - rows.start)
    probabilities[edges], probabilities[across] = (0.3, 0.25), 0.35
    box = Box(EVIDENCE.centers[1], np.eye(3), np.array([0.23, 0.2, 0.01]))
    first = rank_answers(EVIDENCE, 1, probabilities, 0.1, box, UP)[0]
    assert first.joint is not None
    np.testing.assert_allclose(first.joint.pivot, EVIDENCE.pivots[rows][edges[0]])
    assert first.score == pytest.approx(0.3)


def test_a_part_that_rather_rests_gets_no_joint_first() -> None:
    found = answers(1, 0, 0.2, 0.7)
    assert found[0].joint is None
    assert found[1].joint is not None
