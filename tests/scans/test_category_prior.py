"""What is usual among the objects that networks were trained on."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from articulated import shape_of_boxes
from scanned import cupboard_object, hinge, true_answers, true_estimate

from kinmo.config import ScansConfig
from kinmo.core.joint import JointKind
from kinmo.core.mobility import Body
from kinmo.scans.articulated_object import articulated_object
from kinmo.scans.category_prior import Typical
from kinmo.scans.labelled_frames import scan
from kinmo.scans.pose_fitting import PoseOptions, estimate
from kinmo.scans.scan_file import Provenance, ScanFile, open_scans, write_scans
from kinmo.synth.primitives import cylinder

OPTIONS = ScansConfig(states=8, views=6, size=160, points=1024, least_pixels=60)
DEGREE = np.pi / 180


def scanned(folder: Path, target, seed: int = 0) -> ScanFile:
    path = folder / f"{seed}.safetensors"
    write_scans(path, target, scan(target, OPTIONS, seed), Provenance())
    return open_scans(path)


@pytest.fixture(scope="module")
def cupboards(tmp_path_factory) -> list[ScanFile]:
    folder = tmp_path_factory.mktemp("scans")
    return [scanned(folder, cupboard_object(), seed) for seed in range(3)]


def test_boxes_are_square_and_joints_turn_as_far_as_they_were_seen_to(cupboards):
    known = Typical.of(cupboards)
    structure = cupboards[0].structure
    assert known.square.all()
    assert known.along_axes.all()
    for row, kind in enumerate(structure.kinds):
        low, high = known.turns[row]
        if kind is JointKind.PRISMATIC:
            assert np.isnan([low, high]).all()
        else:
            name = "values" if kind is JointKind.REVOLUTE else "turns"
            rest = cupboards[0].joints[row].rest if kind is JointKind.REVOLUTE else 0.0
            states = np.concatenate([file.read(name)[:, row] for file in cupboards]) - rest
            assert states.min() <= low < high <= states.max()
            assert (states >= low).mean() > 0.97


def test_hinges_turn_from_where_they_are_closed_whatever_number_a_file_gives_to_that(cupboards, tmp_path):
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
    found = Typical.of([scanned(tmp_path, counted, seed) for seed in range(3)])
    np.testing.assert_allclose(found.turns, Typical.of(cupboards).turns, atol=1e-6)


def test_what_is_typical_is_the_same_after_it_was_written(cupboards):
    known, structure = Typical.of(cupboards), cupboards[0].structure
    again = Typical.from_data(known.to_data(), structure)
    np.testing.assert_array_equal(again.turns, known.turns)
    np.testing.assert_array_equal(again.square, known.square)
    np.testing.assert_array_equal(again.along_axes, known.along_axes)
    with pytest.raises(ValueError, match="expected those of"):
        Typical.from_data(known.to_data(), replace(structure, kinds=structure.kinds[1:], parents=structure.parents[1:]))


def test_round_parts_and_slanted_joints_are_not_taken_for_square_ones(tmp_path):
    slanted = np.array([0.5, 1.0, 0.0]) / np.linalg.norm([0.5, 1.0, 0.0])
    boxes = [((-1.0, 0.0, -1.0), (1.0, 1.0, 1.0)), ((-1.0, 1.2, -1.0), (1.0, 1.4, 1.0))]
    shape = shape_of_boxes(boxes, [Body(0, "base", (1,)), Body(1, "lid", (2,), 0, hinge((0.0, 1.1, 0.0), slanted))])
    parts = list(shape.parts)
    parts[2] = replace(parts[2], mesh=cylinder(0.3, 1.8, "y", (0.0, 2.1, 0.0), 48))
    target = articulated_object(replace(shape, parts=tuple(parts)), smallest=0.0)
    known = Typical.of([scanned(tmp_path, target)])
    assert known.square.tolist() == [True, False]
    assert known.along_axes.tolist() == [False]


def rough_answers(target, scans, row, rng):
    """What networks may say: places off by what a turn and noise of a few degrees make, directions off together and apart."""
    answers = true_answers(target, scans, row)
    npcs = answers.npcs.copy()
    for part in range(target.structure.part_count):
        own = answers.parts == part
        turn = rng.normal(scale=0.1, size=3)
        npcs[own] += np.cross(turn, npcs[own] - 0.5) + rng.normal(scale=0.03, size=(own.sum(), 3))
    together, apart = rng.normal(scale=0.1, size=3), rng.normal(scale=0.03, size=answers.axes.shape)
    return replace(answers, npcs=npcs, axes=answers.axes + together + apart)


def test_what_is_typical_makes_rough_answers_right(cupboards):
    target = cupboard_object()
    scans, rng = scan(target, OPTIONS, 7), np.random.default_rng(0)
    rows = range(0, len(scans), 4)
    answers = [rough_answers(target, scans, row, rng) for row in rows]
    search = PoseOptions(hypotheses=300)
    off, axes = {}, {}
    for name, known in (("alone", None), ("typical", Typical.of(cupboards))):
        found = estimate(answers, target.structure, search, known)
        true = [true_estimate(target, scans, row) for row in rows]
        both = list(zip(found, true, strict=True))
        cosines = [np.einsum("kii->k", np.swapaxes(t.poses.rotations, 1, 2) @ f.poses.rotations) for f, t in both]
        off[name] = np.median(np.degrees(np.arccos(np.clip(0.5 * (np.array(cosines) - 1.0), -1, 1))), axis=0)
        axes[name] = np.nanmedian([np.abs(np.einsum("ki,ki->k", f.directions, t.directions)) for f, t in both], axis=0)
    assert (off["typical"] < off["alone"]).all(), off
    assert off["typical"][0] < 1.0, "the base faces its axes"
    assert axes["typical"].min() > np.cos(2 * DEGREE)


def test_answers_without_error_are_not_made_worse_by_it(cupboards):
    target = cupboard_object()
    scans = scan(target, OPTIONS, 7)
    rows = range(0, len(scans), 6)
    found = estimate(
        [true_answers(target, scans, row) for row in rows], target.structure, PoseOptions(hypotheses=300), Typical.of(cupboards)
    )
    for row, one in zip(rows, found, strict=True):
        true = true_estimate(target, scans, row)
        assert np.abs(one.poses.rotations - true.poses.rotations).max() < 1e-4
        assert np.abs(one.poses.translations - true.poses.translations).max() < 1e-4


def test_the_papers_ties_make_nothing_of_what_is_typical(cupboards):
    target = cupboard_object()
    scans, rng = scan(target, OPTIONS, 7), np.random.default_rng(0)
    answers = [rough_answers(target, scans, row, rng) for row in range(2)]
    search = PoseOptions(hypotheses=300, ties="pairs")
    alone, known = (estimate(answers, target.structure, search, what) for what in (None, Typical.of(cupboards)))
    for one, other in zip(alone, known, strict=True):
        np.testing.assert_array_equal(one.poses.rotations, other.poses.rotations)
        np.testing.assert_array_equal(one.directions, other.directions)


def test_parts_that_were_not_seen_leave_the_others_as_they_are(cupboards):
    target = cupboard_object()
    scans = scan(target, OPTIONS, 7)
    answers = true_answers(target, scans, 0)
    for lost in (0, 1):
        unseen = replace(answers, parts=np.where(answers.parts == lost, -1, answers.parts))
        (found,) = estimate([unseen], target.structure, PoseOptions(hypotheses=300), Typical.of(cupboards))
        others = np.arange(target.structure.part_count) != lost
        assert list(found.poses.found) == list(others)
        true = true_estimate(target, scans, 0)
        assert np.abs(found.poses.rotations - true.poses.rotations)[others].max() < 1e-4
