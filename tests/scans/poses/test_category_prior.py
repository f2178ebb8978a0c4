"""Category priors, and their effect on pose fitting."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from articulated import shape_of_boxes
from scanned_objects import cupboard_object, hinge, true_estimate, true_predictions

from kinmo.config import ScansConfig
from kinmo.core.joint import JointKind
from kinmo.core.mobility import Body
from kinmo.scans.canonical.articulated_object import articulated_object
from kinmo.scans.files.scan_file import ScanFile, ScanProvenance, open_scans, write_scans
from kinmo.scans.poses.category_prior import CategoryPrior
from kinmo.scans.poses.pose_fitting import PoseOptions, estimate_poses
from kinmo.scans.rendering.labelled_frames import scan_object
from kinmo.synth.primitives import cylinder

OPTIONS = ScansConfig(states=8, views=6, size=160, points=1024, least_pixels=60)
DEGREE = np.pi / 180


def write_scan_file(folder: Path, target, seed: int = 0) -> ScanFile:
    path = folder / f"{seed}.safetensors"
    write_scans(path, target, scan_object(target, OPTIONS, seed), ScanProvenance())
    return open_scans(path)


@pytest.fixture(scope="module")
def cupboards(tmp_path_factory) -> list[ScanFile]:
    folder = tmp_path_factory.mktemp("scans")
    return [write_scan_file(folder, cupboard_object(), seed) for seed in range(3)]


def test_boxes_are_axis_aligned_and_turn_ranges_cover_the_states(cupboards):
    prior = CategoryPrior.from_scans(cupboards)
    structure = cupboards[0].structure
    assert prior.axis_aligned.all()
    assert prior.along_axes.all()
    for row, kind in enumerate(structure.kinds):
        low, high = prior.turn_ranges[row]
        if kind is JointKind.PRISMATIC:
            assert np.isnan([low, high]).all()
        else:
            name = "values" if kind is JointKind.REVOLUTE else "turns"
            rest = cupboards[0].joints[row].rest if kind is JointKind.REVOLUTE else 0.0
            states = np.concatenate([file.read(name)[:, row] for file in cupboards]) - rest
            assert states.min() <= low < high <= states.max()
            assert (states >= low).mean() > 0.97


def test_turn_ranges_count_from_the_closed_pose(cupboards, tmp_path):
    target = cupboard_object()
    bodies = [
        body
        if body.joint is None or body.joint.kind is not JointKind.REVOLUTE
        else replace(
            body, joint=replace(body.joint, **{end: getattr(body.joint, end) + 0.4 for end in ("lower", "upper", "rest")})
        )
        for body in target.mobility.bodies
    ]
    counted = replace(target, mobility=replace(target.mobility, bodies=tuple(bodies)))
    found = CategoryPrior.from_scans([write_scan_file(tmp_path, counted, seed) for seed in range(3)])
    np.testing.assert_allclose(found.turn_ranges, CategoryPrior.from_scans(cupboards).turn_ranges, atol=1e-6)


def test_a_prior_is_read_as_written(cupboards):
    prior, structure = CategoryPrior.from_scans(cupboards), cupboards[0].structure
    again = CategoryPrior.from_data(prior.to_data(), structure)
    np.testing.assert_array_equal(again.turn_ranges, prior.turn_ranges)
    np.testing.assert_array_equal(again.axis_aligned, prior.axis_aligned)
    np.testing.assert_array_equal(again.along_axes, prior.along_axes)
    with pytest.raises(ValueError, match="expected those of"):
        CategoryPrior.from_data(prior.to_data(), replace(structure, kinds=structure.kinds[1:], parents=structure.parents[1:]))


def test_round_parts_and_slanted_joints_are_not_axis_aligned(tmp_path):
    slanted = np.array([0.5, 1.0, 0.0]) / np.linalg.norm([0.5, 1.0, 0.0])
    boxes = [((-1.0, 0.0, -1.0), (1.0, 1.0, 1.0)), ((-1.0, 1.2, -1.0), (1.0, 1.4, 1.0))]
    shape = shape_of_boxes(boxes, [Body(0, "base", (1,)), Body(1, "lid", (2,), 0, hinge((0.0, 1.1, 0.0), slanted))])
    parts = list(shape.parts)
    parts[2] = replace(parts[2], mesh=cylinder(0.3, 1.8, "y", (0.0, 2.1, 0.0), 48))
    target = articulated_object(replace(shape, parts=tuple(parts)), min_part_size=0.0)
    prior = CategoryPrior.from_scans([write_scan_file(tmp_path, target)])
    assert prior.axis_aligned.tolist() == [True, False]
    assert prior.along_axes.tolist() == [False]


def noisy_predictions(target, scans, row, rng):
    """Predictions with errors of a few degrees: some common to a part, some independent for each point."""
    predictions = true_predictions(target, scans, row)
    npcs = predictions.npcs.copy()
    for part in range(target.structure.part_count):
        own = predictions.parts == part
        turn = rng.normal(scale=0.1, size=3)
        npcs[own] += np.cross(turn, npcs[own] - 0.5) + rng.normal(scale=0.03, size=(own.sum(), 3))
    together, apart = rng.normal(scale=0.1, size=3), rng.normal(scale=0.03, size=predictions.axes.shape)
    return replace(predictions, npcs=npcs, axes=predictions.axes + together + apart)


def test_the_prior_corrects_noisy_predictions(cupboards):
    target = cupboard_object()
    scans, rng = scan_object(target, OPTIONS, 7), np.random.default_rng(0)
    rows = range(0, len(scans), 4)
    predictions = [noisy_predictions(target, scans, row, rng) for row in rows]
    search = PoseOptions(hypotheses=300)
    off, axes = {}, {}
    for name, prior in (("alone", None), ("prior", CategoryPrior.from_scans(cupboards))):
        found = estimate_poses(predictions, target.structure, search, prior)
        true = [true_estimate(target, scans, row) for row in rows]
        both = list(zip(found, true, strict=True))
        cosines = [np.einsum("kii->k", np.swapaxes(t.poses.rotations, 1, 2) @ f.poses.rotations) for f, t in both]
        off[name] = np.median(np.degrees(np.arccos(np.clip(0.5 * (np.array(cosines) - 1.0), -1, 1))), axis=0)
        axes[name] = np.nanmedian([np.abs(np.einsum("ki,ki->k", f.directions, t.directions)) for f, t in both], axis=0)
    assert (off["prior"] < off["alone"]).all(), off
    assert off["prior"][0] < 1.0, "the base is axis-aligned"
    assert axes["prior"].min() > np.cos(2 * DEGREE)


def test_the_prior_keeps_perfect_predictions(cupboards):
    target = cupboard_object()
    scans = scan_object(target, OPTIONS, 7)
    rows = range(0, len(scans), 6)
    found = estimate_poses(
        [true_predictions(target, scans, row) for row in rows],
        target.structure,
        PoseOptions(hypotheses=300),
        CategoryPrior.from_scans(cupboards),
    )
    for row, one in zip(rows, found, strict=True):
        true = true_estimate(target, scans, row)
        assert np.abs(one.poses.rotations - true.poses.rotations).max() < 1e-4
        assert np.abs(one.poses.translations - true.poses.translations).max() < 1e-4


def test_the_ties_of_the_paper_ignore_the_prior(cupboards):
    target = cupboard_object()
    scans, rng = scan_object(target, OPTIONS, 7), np.random.default_rng(0)
    predictions = [noisy_predictions(target, scans, row, rng) for row in range(2)]
    search = PoseOptions(hypotheses=300, ties="pairs")
    alone, prior = (
        estimate_poses(predictions, target.structure, search, what) for what in (None, CategoryPrior.from_scans(cupboards))
    )
    for one, other in zip(alone, prior, strict=True):
        np.testing.assert_array_equal(one.poses.rotations, other.poses.rotations)
        np.testing.assert_array_equal(one.directions, other.directions)


def test_an_invisible_part_does_not_change_the_others(cupboards):
    target = cupboard_object()
    scans = scan_object(target, OPTIONS, 7)
    predictions = true_predictions(target, scans, 0)
    for lost in (0, 1):
        unseen = replace(predictions, parts=np.where(predictions.parts == lost, -1, predictions.parts))
        (found,) = estimate_poses([unseen], target.structure, PoseOptions(hypotheses=300), CategoryPrior.from_scans(cupboards))
        others = np.arange(target.structure.part_count) != lost
        assert list(found.poses.found) == list(others)
        true = true_estimate(target, scans, 0)
        assert np.abs(found.poses.rotations - true.poses.rotations)[others].max() < 1e-4
