"""Poses, boxes, joints and joint states from point predictions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from articulated import shape_of_boxes
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scanned_objects import UP, cupboard_object, hinge, screw, slider, true_estimate, true_global_predictions, true_predictions
from scipy.spatial.transform import Rotation

from kinmo.config import ScansConfig
from kinmo.core.mobility import Body
from kinmo.evaluation.scan_metrics import score_frame
from kinmo.scans.canonical.articulated_object import ArticulatedObject, articulated_object
from kinmo.scans.poses.category_prior import CategoryPrior
from kinmo.scans.poses.pose_fitting import PoseOptions, estimate_poses, turn_about
from kinmo.scans.preprocessing.input_frame import InputFrame
from kinmo.scans.rendering.labelled_frames import scan_object

OPTIONS = ScansConfig(states=3, views=4, size=160, points=600, least_pixels=150)
SEARCH = PoseOptions(hypotheses=300)
DEGREE = np.pi / 180


def row_of_boxes(kinds: list[str], on_each_other: bool, tilts: list[np.ndarray] | None = None) -> ArticulatedObject:
    """Boxes in a row with a joint each, on the first box or on the one before; axes point up, turned by `tilts`."""
    ups = [UP] * len(kinds) if tilts is None else [Rotation.from_rotvec(tilt).apply(UP) for tilt in tilts]
    boxes = [((float(i), 0.0, 0.0), (i + 0.9, 1.0 + 0.1 * i, 0.7)) for i in range(len(kinds) + 1)]
    bodies = [Body(0, "base", (1,))]
    for index, (kind, up) in enumerate(zip(kinds, ups, strict=True), start=1):
        middle = (index + 0.45, 0.0, 0.35)
        joint = {"R": hinge((index, 0.0, 0.0), up), "P": slider(up), "PR": screw(middle, up)}[kind]
        bodies.append(Body(index, f"part {index}", (index + 1,), index - 1 if on_each_other else 0, joint))
    return articulated_object(shape_of_boxes(boxes, bodies), min_part_size=0.0)


def test_openings_beyond_half_a_turn_are_found() -> None:
    boxes = [((0.0, 0.0, 0.0), (0.9, 1.0, 0.7)), ((1.0, 0.0, 0.0), (1.9, 1.1, 0.7))]
    bodies = [Body(0, "base", (1,)), Body(1, "cover", (2,), 0, hinge((1.0, 0.0, 0.0), upper=4.0))]
    target = articulated_object(shape_of_boxes(boxes, bodies), min_part_size=0.0)
    scans = scan_object(target, replace(OPTIONS, states=12, views=1), 0)
    predictions = [true_predictions(target, scans, row) for row in range(len(scans))]
    true = np.array([true_estimate(target, scans, row).states[0] for row in range(len(scans))])
    assert (true > np.pi).any()
    assert (true < np.pi).any()
    prior = replace(full_prior(target), turn_ranges=np.array([[0.0, 4.0]]))
    found = [one.states[0] for one in estimate_poses(predictions, target.structure, SEARCH, prior)]
    assert found == pytest.approx(true, abs=0.01 * DEGREE)


@pytest.mark.parametrize("ties", ["tree", "pairs"])
@settings(max_examples=8)
@given(st.lists(st.sampled_from(["R", "P", "PR"]), min_size=1, max_size=5), st.booleans(), st.integers(0, 1000))
def test_perfect_predictions_give_true_poses_joints_and_states(ties, kinds, on_each_other, seed) -> None:
    check_perfect_predictions(row_of_boxes(kinds, on_each_other), replace(SEARCH, ties=ties), seed)


KINDS = st.sampled_from(["R", "P", "PR"])
TILTS = st.tuples(st.floats(-0.4, 0.4), st.sampled_from([0.0, 1.5, 3.0]), st.floats(-0.4, 0.4)).map(np.array)
"""Rotations that leave most axes within about 20 degrees of a coordinate axis."""


@pytest.mark.parametrize("knows", [False, True])
@settings(max_examples=12)
@given(st.lists(st.tuples(KINDS, TILTS), min_size=1, max_size=5), st.booleans(), st.integers(0, 1000))
def test_perfect_predictions_give_true_joints_with_any_prior(knows, joints, on_each_other, seed) -> None:
    target = row_of_boxes([kind for kind, _ in joints], on_each_other, [tilt for _, tilt in joints])
    check_perfect_predictions(target, SEARCH, seed, full_prior(target) if knows else None)


def full_prior(target: ArticulatedObject) -> CategoryPrior:
    """A prior of axis-aligned boxes with joints along the axes that turn up to 1.5 rad."""
    joints = len(target.joints)
    return CategoryPrior(np.tile([0.0, 1.5], (joints, 1)), np.ones(joints + 1, bool), np.ones(joints, bool))


def check_perfect_predictions(
    target: ArticulatedObject, options: PoseOptions, seed: int, prior: CategoryPrior | None = None
) -> None:
    scans = scan_object(target, OPTIONS, seed)
    assume(len(scans) > 0)
    predictions = [true_predictions(target, scans, row) for row in range(len(scans))]
    for row, found in enumerate(estimate_poses(predictions, target.structure, options, prior)):
        score = score_frame(found, true_estimate(target, scans, row), target.structure)
        votes = np.bincount(predictions[row].joints, minlength=target.structure.part_count)[1:]
        assert score.is_whole or not votes.all(), "only an axis without votes may be unknown"
        assert score.rotation.max() < 1e-4
        assert score.translation.max() < 1e-4
        voted = votes >= (1 if prior is None else 2)  # a single voter has no spread
        assert (score.axis[voted] < 0.01 * DEGREE).all()
        assert np.nanmax(score.line[voted], initial=0.0) < 1e-4
        turning = np.array([kind.value == "R" for kind in target.structure.kinds])
        assert (score.state < np.where(turning, 0.01 * DEGREE, 1e-4))[voted].all()
        screws = np.array([kind.value == "PR" for kind in target.structure.kinds])
        assert np.isnan(score.turn[~screws]).all()
        assert (score.turn[screws & voted] < 0.01 * DEGREE).all()


@pytest.mark.parametrize("kind", ["R", "PR"])
def test_a_direction_does_not_snap_if_the_parts_fit_worse(kind) -> None:
    target = row_of_boxes([kind], on_each_other=False, tilts=[np.array([0.2, 0.0, 0.1])])
    scans = scan_object(target, OPTIONS, 0)
    rng = np.random.default_rng(0)
    predictions = [true_predictions(target, scans, row) for row in range(len(scans))]
    predictions = [replace(one, axes=one.axes + rng.normal(scale=0.02, size=one.axes.shape)) for one in predictions]
    turned = (scans.values if kind == "R" else scans.turns)[:, 0]
    for row, found in enumerate(estimate_poses(predictions, target.structure, SEARCH, full_prior(target))):
        if abs(turned[row]) > 0.2:
            score = score_frame(found, true_estimate(target, scans, row), target.structure)
            assert score.axis[0] < 1.5 * DEGREE
            assert score.rotation.max() < 0.5 * DEGREE


def test_a_direction_near_an_axis_snaps_to_it() -> None:
    target = row_of_boxes(["R", "P", "PR"], on_each_other=False)
    scans = scan_object(target, OPTIONS, 0)
    rng = np.random.default_rng(0)
    for row in range(len(scans)):
        predictions = true_predictions(target, scans, row)
        count = (len(predictions.parts), 3)
        tilted = Rotation.from_rotvec([0.1, 0.0, -0.1]).apply(predictions.axes)
        predictions = replace(
            predictions,
            axes=tilted + rng.normal(scale=0.02, size=count),
            npcs=predictions.npcs + rng.normal(scale=0.03, size=count),
        )
        off = {}
        for prior in (None, full_prior(target)):
            (found,) = estimate_poses([predictions], target.structure, SEARCH, prior)
            off[prior is None] = score_frame(found, true_estimate(target, scans, row), target.structure).axis
        assert np.nanmax(off[False]) < 1.5 * DEGREE
        assert np.nanmin(off[True]) > 3.0 * DEGREE


def test_global_predictions_give_whole_boxes_and_pivots() -> None:
    target = cupboard_object()
    scans = scan_object(target, OPTIONS, 0)
    predictions = true_predictions(target, scans, 0)
    predictions = replace(predictions, pivots=predictions.pivots + 1.0, whole=true_global_predictions(target))
    (found,) = estimate_poses([predictions], target.structure, replace(SEARCH, boxes="predicted"))
    score = score_frame(found, true_estimate(target, scans, 0), target.structure)
    assert score.iou.min() > 0.999
    assert np.nanmax(score.line) < 1e-4


@pytest.mark.parametrize("factor", [0.8, 1.25])
def test_boxes_of_a_wrong_size_are_fitted_to_their_visible_sides(factor) -> None:
    target = cupboard_object()
    scans = scan_object(target, OPTIONS, 0)
    true = true_global_predictions(target)
    predictions = [
        replace(true_predictions(target, scans, row), whole=replace(true, half_sizes=factor * true.half_sizes))
        for row in range(len(scans))
    ]
    overlaps = {}
    for boxes in ("predicted", "fitted"):
        found = estimate_poses(predictions, target.structure, replace(SEARCH, boxes=boxes))
        scores = [score_frame(one, true_estimate(target, scans, row), target.structure) for row, one in enumerate(found)]
        overlaps[boxes] = np.mean([score.iou for score in scores])
        assert np.max([score.translation for score in scores]) < 1e-4
    assert overlaps["predicted"] < 0.55
    assert overlaps["fitted"] > overlaps["predicted"] + 0.05


def test_the_estimate_does_not_depend_on_the_input_frame() -> None:
    target = cupboard_object()
    scans = scan_object(target, OPTIONS, 0)
    true = true_estimate(target, scans, 0)
    for frame in (InputFrame(np.zeros(3), 1.0), InputFrame(np.array([0.1, -0.2, 1.0]), 1.7)):
        (found,) = estimate_poses([true_predictions(target, scans, 0, frame)], target.structure, SEARCH)
        score = score_frame(found, true, target.structure)
        assert score.rotation.max() < 1e-4
        assert np.abs(found.poses.translations - true.poses.translations).max() < 1e-4
        assert np.nanmax(score.line) < 1e-4


def test_joints_improve_a_part_with_few_points() -> None:
    target = row_of_boxes(["R"], on_each_other=False)
    scans = scan_object(target, OPTIONS, 5)
    rng = np.random.default_rng(0)
    off = {"joint": [], "none": []}
    for row in range(len(scans)):
        predictions = true_predictions(target, scans, row)
        few = np.flatnonzero(predictions.parts == 1)[8:]
        kept = np.setdiff1d(np.arange(len(predictions.parts)), few)
        noisy = predictions.npcs + rng.normal(scale=0.02, size=predictions.npcs.shape)
        predictions = replace(
            predictions, points=predictions.points[kept], parts=predictions.parts[kept], npcs=noisy[kept],
            joints=predictions.joints[kept], axes=predictions.axes[kept], pivots=predictions.pivots[kept],
        )  # fmt: skip
        for name, factor in (("joint", 1.0), ("none", np.nan)):
            known = replace(predictions, axes=factor * predictions.axes)
            (found,) = estimate_poses([known], target.structure, SEARCH)
            off[name].append(score_frame(found, true_estimate(target, scans, row), target.structure).rotation[1])
    assert np.median(off["joint"]) < np.median(off["none"])


@pytest.mark.parametrize("left", [0, 2])
def test_a_part_without_points_is_nan_and_the_others_are_found(left: int) -> None:
    target = cupboard_object()
    scans = scan_object(target, OPTIONS, 0)
    predictions = true_predictions(target, scans, 0)
    lost = 1
    # two points give no pose either
    predictions = replace(
        predictions,
        parts=np.where((predictions.parts == lost) & (np.cumsum(predictions.parts == lost) > left), -1, predictions.parts),
    )
    for ties in ("tree", "pairs"):
        (found,) = estimate_poses([predictions], target.structure, replace(SEARCH, ties=ties))
        assert list(found.poses.found) == [True, False, True, True]
        assert list(np.isnan(found.inliers)) == [False, True, False, False]
        score = score_frame(found, true_estimate(target, scans, 0), target.structure)
        assert not score.is_whole
        assert np.nanmax(score.rotation) < 1e-4
        assert np.isnan(score.state[lost - 1])
        assert np.isnan(score.iou[lost])


@pytest.mark.parametrize("ties", ["tree", "pairs"])
def test_a_scan_has_the_same_estimate_alone_and_among_others(ties) -> None:
    target = cupboard_object()
    scans = scan_object(target, OPTIONS, 0)
    whole, seen = (true_predictions(target, scans, row) for row in (0, 1))
    tilted = Rotation.from_rotvec([0.0, 0.09, 0.0]).apply(seen.npcs - 0.5) + 0.5  # the prior turns the axis-aligned base back
    base_alone = replace(seen, parts=np.where(seen.parts == 0, 0, -1), npcs=tilted)
    options, prior = replace(SEARCH, ties=ties), full_prior(target)
    both = estimate_poses([whole, base_alone], target.structure, options, prior)
    each = [estimate_poses([predictions], target.structure, options, prior)[0] for predictions in (whole, base_alone)]
    for together, alone in zip(both, each, strict=True):
        for name in ("rotations", "scales", "translations"):
            assert np.array_equal(getattr(together.poses, name), getattr(alone.poses, name), equal_nan=True)
        assert np.array_equal(together.half_extents, alone.half_extents, equal_nan=True)
    assert estimate_poses([], target.structure, options, prior) == []


def test_amodal_boxes_enclose_the_visible_points() -> None:
    target = cupboard_object()
    scans = scan_object(target, OPTIONS, 0)
    (found,) = estimate_poses([true_predictions(target, scans, 0)], target.structure, SEARCH)
    true = true_estimate(target, scans, 0)
    assert (found.half_extents <= true.half_extents + 1e-4).all()
    score = score_frame(found, true, target.structure)
    assert (score.iou > 0.5).all()
    assert score_frame(true, true, target.structure).iou == pytest.approx(np.ones(4))


@given(st.floats(-3.1, 3.1), st.integers(0, 100))
def test_the_turn_about_an_axis_is_read_from_a_rotation(angle, seed) -> None:
    axis = Rotation.random(random_state=seed).as_matrix()[0]
    assert turn_about(Rotation.from_rotvec(angle * axis).as_matrix(), axis) == pytest.approx(angle, abs=1e-9)
