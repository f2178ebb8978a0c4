"""Poses, joints and states from what is said of points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from articulated import shape_of_boxes
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scanned import UP, cupboard_object, hinge, screw, slider, true_answers, true_estimate, true_layout
from scipy.spatial.transform import Rotation

from kinmo.config import ScansConfig
from kinmo.core.mobility import Body
from kinmo.evaluation.scan_metrics import score_frame
from kinmo.scans.articulated_object import ArticulatedObject, articulated_object
from kinmo.scans.category_prior import Typical
from kinmo.scans.input_frame import InputFrame
from kinmo.scans.labelled_frames import scan
from kinmo.scans.pose_fitting import PoseOptions, estimate, turn_about

OPTIONS = ScansConfig(states=3, views=4, size=160, points=600, least_pixels=150)
SEARCH = PoseOptions(hypotheses=300, pair_hypotheses=100)
DEGREE = np.pi / 180


def row_of_boxes(kinds: list[str], on_each_other: bool, tilts: list[np.ndarray] | None = None) -> ArticulatedObject:
    """Boxes in a row with a joint each, on the first box or each on the one before; axes are up, turned by the `tilts`."""
    ups = [UP] * len(kinds) if tilts is None else [Rotation.from_rotvec(tilt).apply(UP) for tilt in tilts]
    boxes = [((float(i), 0.0, 0.0), (i + 0.9, 1.0 + 0.1 * i, 0.7)) for i in range(len(kinds) + 1)]
    bodies = [Body(0, "base", (1,))]
    for index, (kind, up) in enumerate(zip(kinds, ups, strict=True), start=1):
        middle = (index + 0.45, 0.0, 0.35)
        joint = {"R": hinge((index, 0.0, 0.0), up), "P": slider(up), "PR": screw(middle, up)}[kind]
        bodies.append(Body(index, f"part {index}", (index + 1,), index - 1 if on_each_other else 0, joint))
    return articulated_object(shape_of_boxes(boxes, bodies), smallest=0.0)


def test_what_opens_farther_than_half_a_turn_is_said_to_be_open_so_far() -> None:
    boxes = [((0.0, 0.0, 0.0), (0.9, 1.0, 0.7)), ((1.0, 0.0, 0.0), (1.9, 1.1, 0.7))]
    bodies = [Body(0, "base", (1,)), Body(1, "cover", (2,), 0, hinge((1.0, 0.0, 0.0), upper=4.0))]
    target = articulated_object(shape_of_boxes(boxes, bodies), smallest=0.0)
    scans = scan(target, replace(OPTIONS, states=12, views=1), 0)
    answers = [true_answers(target, scans, row) for row in range(len(scans))]
    true = np.array([true_estimate(target, scans, row).states[0] for row in range(len(scans))])
    assert (true > np.pi).any()
    assert (true < np.pi).any()
    typical = replace(all_is_typical(target), turns=np.array([[0.0, 4.0]]))
    found = [one.states[0] for one in estimate(answers, target.structure, SEARCH, typical)]
    assert found == pytest.approx(true, abs=0.01 * DEGREE)


@pytest.mark.parametrize("ties", ["tree", "pairs", "none"])
@settings(max_examples=8)
@given(st.lists(st.sampled_from(["R", "P", "PR"]), min_size=1, max_size=5), st.booleans(), st.integers(0, 1000))
def test_answers_without_error_give_poses_joints_and_states_back(ties, kinds, on_each_other, seed) -> None:
    check_answers_without_error(row_of_boxes(kinds, on_each_other), replace(SEARCH, ties=ties), seed)


KINDS = st.sampled_from(["R", "P", "PR"])
TILTS = st.tuples(st.floats(-0.4, 0.4), st.sampled_from([0.0, 1.5, 3.0]), st.floats(-0.4, 0.4)).map(np.array)
"""Most axes are within 20 degrees of one of the coordinates, or little farther off."""


@pytest.mark.parametrize("knows", [False, True])
@settings(max_examples=12)
@given(st.lists(st.tuples(KINDS, TILTS), min_size=1, max_size=5), st.booleans(), st.integers(0, 1000))
def test_answers_without_error_are_right_whatever_is_typical(knows, joints, on_each_other, seed) -> None:
    target = row_of_boxes([kind for kind, _ in joints], on_each_other, [tilt for _, tilt in joints])
    check_answers_without_error(target, SEARCH, seed, all_is_typical(target) if knows else None)


def all_is_typical(target: ArticulatedObject) -> Typical:
    """Boxes with hinges that open to 1.5 rad, along the axes."""
    joints = len(target.joints)
    return Typical(np.tile([0.0, 1.5], (joints, 1)), np.ones(joints + 1, bool), np.ones(joints, bool))


def check_answers_without_error(
    target: ArticulatedObject, options: PoseOptions, seed: int, typical: Typical | None = None
) -> None:
    scans = scan(target, OPTIONS, seed)
    assume(len(scans) > 0)
    answers = [true_answers(target, scans, row) for row in range(len(scans))]
    for row, found in enumerate(estimate(answers, target.structure, options, typical)):
        score = score_frame(found, true_estimate(target, scans, row), target.structure)
        assert score.is_whole
        assert score.rotation.max() < 1e-4
        assert score.translation.max() < 1e-4
        # the others' axes are out of sight, and of a single point nothing shows how far it is to be relied on
        told = np.bincount(answers[row].joints, minlength=target.structure.part_count)[1:] >= (1 if typical is None else 2)
        assert (score.axis[told] < 0.01 * DEGREE).all()
        assert np.nanmax(score.line[told], initial=0.0) < 1e-4
        turning = np.array([kind.value == "R" for kind in target.structure.kinds])
        assert (score.state < np.where(turning, 0.01 * DEGREE, 1e-4))[told].all()
        screws = np.array([kind.value == "PR" for kind in target.structure.kinds])
        assert np.isnan(score.turn[~screws]).all()
        assert (score.turn[screws & told] < 0.01 * DEGREE).all()


@pytest.mark.parametrize("kind", ["R", "PR"])
def test_where_parts_would_lie_worse_about_the_typical_axis_that_said_is_taken(kind) -> None:
    target = row_of_boxes([kind], on_each_other=False, tilts=[np.array([0.2, 0.0, 0.1])])
    scans = scan(target, OPTIONS, 0)
    rng = np.random.default_rng(0)
    answers = [true_answers(target, scans, row) for row in range(len(scans))]
    answers = [replace(one, axes=one.axes + rng.normal(scale=0.02, size=one.axes.shape)) for one in answers]
    turned = (scans.values if kind == "R" else scans.turns)[:, 0]
    for row, found in enumerate(estimate(answers, target.structure, SEARCH, all_is_typical(target))):
        if abs(turned[row]) > 0.2:
            score = score_frame(found, true_estimate(target, scans, row), target.structure)
            assert score.axis[0] < 1.5 * DEGREE
            assert score.rotation.max() < 0.5 * DEGREE


def test_what_is_typically_along_an_axis_and_said_to_be_nearly_is_along_it() -> None:
    target = row_of_boxes(["R", "P", "PR"], on_each_other=False)
    scans = scan(target, OPTIONS, 0)
    rng = np.random.default_rng(0)
    for row in range(len(scans)):
        answers = true_answers(target, scans, row)
        count = (len(answers.parts), 3)
        tilted = Rotation.from_rotvec([0.1, 0.0, -0.1]).apply(answers.axes)
        answers = replace(
            answers,
            axes=tilted + rng.normal(scale=0.02, size=count),
            npcs=answers.npcs + rng.normal(scale=0.03, size=count),
        )
        off = {}
        for typical in (None, all_is_typical(target)):
            (found,) = estimate([answers], target.structure, SEARCH, typical)
            off[typical is None] = score_frame(found, true_estimate(target, scans, row), target.structure).axis
        assert np.nanmax(off[False]) < 1.5 * DEGREE
        assert np.nanmin(off[True]) > 3.0 * DEGREE


def test_what_is_said_of_the_whole_makes_boxes_whole_and_places_axes_in_the_camera_s_frame() -> None:
    target = cupboard_object()
    scans = scan(target, OPTIONS, 0)
    answers = true_answers(target, scans, 0)
    answers = replace(answers, pivots=answers.pivots + 1.0, layout=true_layout(target))
    (found,) = estimate([answers], target.structure, replace(SEARCH, boxes="said"))
    score = score_frame(found, true_estimate(target, scans, 0), target.structure)
    assert score.iou.min() > 0.999
    assert np.nanmax(score.line) < 1e-4


@pytest.mark.parametrize("said", [0.8, 1.25])
def test_boxes_that_are_said_too_small_or_too_large_have_sides_where_these_are_seen(said) -> None:
    target = cupboard_object()
    scans = scan(target, OPTIONS, 0)
    true = true_layout(target)
    answers = [
        replace(true_answers(target, scans, row), layout=replace(true, half_sizes=said * true.half_sizes))
        for row in range(len(scans))
    ]
    overlaps = {}
    for boxes in ("said", "seen"):
        found = estimate(answers, target.structure, replace(SEARCH, boxes=boxes))
        scores = [score_frame(one, true_estimate(target, scans, row), target.structure) for row, one in enumerate(found)]
        overlaps[boxes] = np.mean([score.iou for score in scores])
        assert np.max([score.translation for score in scores]) < 1e-4
    assert overlaps["said"] < 0.55
    assert overlaps["seen"] > overlaps["said"] + 0.05


def test_where_a_scan_lies_and_how_large_it_is_for_the_network_does_not_matter() -> None:
    target = cupboard_object()
    scans = scan(target, OPTIONS, 0)
    true = true_estimate(target, scans, 0)
    for frame in (InputFrame(np.zeros(3), 1.0), InputFrame(np.array([0.1, -0.2, 1.0]), 1.7)):
        (found,) = estimate([true_answers(target, scans, 0, frame)], target.structure, SEARCH)
        score = score_frame(found, true, target.structure)
        assert score.rotation.max() < 1e-4
        assert np.abs(found.poses.translations - true.poses.translations).max() < 1e-4
        assert np.nanmax(score.line) < 1e-4


def test_joints_make_a_part_right_of_which_little_is_seen() -> None:
    target = row_of_boxes(["R"], on_each_other=False)
    scans = scan(target, OPTIONS, 5)
    rng = np.random.default_rng(0)
    off = {"none": [], "tree": []}
    for row in range(len(scans)):
        answers = true_answers(target, scans, row)
        few = np.flatnonzero(answers.parts == 1)[8:]
        kept = np.setdiff1d(np.arange(len(answers.parts)), few)
        noisy = answers.npcs + rng.normal(scale=0.02, size=answers.npcs.shape)
        answers = replace(
            answers, points=answers.points[kept], parts=answers.parts[kept], npcs=noisy[kept],
            joints=answers.joints[kept], axes=answers.axes[kept], pivots=answers.pivots[kept],
        )  # fmt: skip
        for ties in off:
            (found,) = estimate([answers], target.structure, replace(SEARCH, ties=ties))
            off[ties].append(score_frame(found, true_estimate(target, scans, row), target.structure).rotation[1])
    assert np.median(off["tree"]) < np.median(off["none"])


@pytest.mark.parametrize("left", [0, 2])
def test_a_part_of_which_nothing_is_said_is_nan_and_the_others_are_found(left: int) -> None:
    target = cupboard_object()
    scans = scan(target, OPTIONS, 0)
    answers = true_answers(target, scans, 0)
    lost = 1
    # of two points no pose can be told either
    answers = replace(
        answers, parts=np.where((answers.parts == lost) & (np.cumsum(answers.parts == lost) > left), -1, answers.parts)
    )
    for ties in ("tree", "pairs", "none"):
        (found,) = estimate([answers], target.structure, replace(SEARCH, ties=ties))
        assert list(found.poses.found) == [True, False, True, True]
        assert list(np.isnan(found.inliers)) == [False, True, False, False]
        score = score_frame(found, true_estimate(target, scans, 0), target.structure)
        assert not score.is_whole
        assert np.nanmax(score.rotation) < 1e-4
        assert np.isnan(score.state[lost - 1])
        assert np.isnan(score.iou[lost])


@pytest.mark.parametrize("ties", ["tree", "pairs", "none"])
def test_what_is_found_in_a_scan_does_not_depend_on_those_that_are_looked_at_with_it(ties) -> None:
    target = cupboard_object()
    scans = scan(target, OPTIONS, 0)
    whole, seen = (true_answers(target, scans, row) for row in (0, 1))
    tilted = Rotation.from_rotvec([0.0, 0.09, 0.0]).apply(seen.npcs - 0.5) + 0.5  # its base is square, and so turned back
    base_alone = replace(seen, parts=np.where(seen.parts == 0, 0, -1), npcs=tilted)
    options, typical = replace(SEARCH, ties=ties), all_is_typical(target)
    both = estimate([whole, base_alone], target.structure, options, typical)
    each = [estimate([answers], target.structure, options, typical)[0] for answers in (whole, base_alone)]
    for together, alone in zip(both, each, strict=True):
        for name in ("rotations", "scales", "translations"):
            assert np.array_equal(getattr(together.poses, name), getattr(alone.poses, name), equal_nan=True)
        assert np.array_equal(together.half_extents, alone.half_extents, equal_nan=True)
    assert estimate([], target.structure, options, typical) == []


def test_amodal_boxes_are_as_large_as_what_is_seen_reaches_from_their_middle() -> None:
    target = cupboard_object()
    scans = scan(target, OPTIONS, 0)
    (found,) = estimate([true_answers(target, scans, 0)], target.structure, SEARCH)
    true = true_estimate(target, scans, 0)
    assert (found.half_extents <= true.half_extents + 1e-4).all()
    score = score_frame(found, true, target.structure)
    assert (score.iou > 0.5).all()
    assert score_frame(true, true, target.structure).iou == pytest.approx(np.ones(4))


@given(st.floats(-3.1, 3.1), st.integers(0, 100))
def test_the_turn_about_an_axis_is_read_off_a_rotation(angle, seed) -> None:
    axis = Rotation.random(random_state=seed).as_matrix()[0]
    assert turn_about(Rotation.from_rotvec(angle * axis).as_matrix(), axis) == pytest.approx(angle, abs=1e-9)
