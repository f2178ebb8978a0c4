"""All families build sound objects for any seed."""

from __future__ import annotations

from collections import Counter
from functools import cache

import numpy as np
import pytest

from kinmo import _core
from kinmo.core.categories import canonical_category
from kinmo.core.errors import InputError
from kinmo.core.joint import Joint, JointKind
from kinmo.core.motion_types import MotionType, motion_type
from kinmo.core.oriented_box import Box
from kinmo.io.readers import PARTNET_MOBILITY
from kinmo.synth.draw import Draw, ParameterRange
from kinmo.synth.families import family_builder, family_names
from kinmo.synth.generate import ShapeSpec, build_shape
from kinmo.synth.synth_object import Link, Motion, SynthObject

SEEDS = 6
UP = np.array([0.0, 1.0, 0.0])


def spec(name: str, index: int) -> ShapeSpec:
    return ShapeSpec(name, index, 11, PARTNET_MOBILITY, ParameterRange.BOTH)


@cache
def built(name: str, index: int) -> SynthObject:
    """An object that several tests look at, and none changes."""
    return build_shape(spec(name, index))


@pytest.mark.parametrize("name", family_names())
def test_a_family_builds_sound_objects(name: str) -> None:
    structures = set()
    for index in range(SEEDS):
        obj = built(name, index)
        obj.check()
        assert name == "table" or any(link.motion is not None for link in obj.links), "only tables may have no joint"
        assert all(link.parent is not None for link in obj.links if link.motion is not None)
        for leaf in obj.root.leaves():
            for piece in leaf.pieces:
                assert np.isfinite(piece.vertices).all()
                assert piece.faces.max() < len(piece.vertices)
                assert np.ptp(piece.vertices, axis=0).max() > 0.0
        low, high = obj.bounds()
        assert 1.7 < np.linalg.norm(high - low) < 2.3
        assert np.abs(0.5 * (low + high)).max() < 0.05
        for link in obj.links:
            if link.motion is not None:
                assert np.isfinite(link.motion.origin).all()
                assert 0.05 < np.linalg.norm(link.motion.direction) < 1.1
        structures.add(tuple(sorted(len(leaf.pieces) for leaf in obj.root.leaves())))
    assert len(structures) > 1, "a family varies in its parts"


@pytest.mark.parametrize("name", family_names())
def test_joints_are_at_their_parts(name: str) -> None:
    for index in range(2):
        obj = built(name, index)
        for link in obj.links:
            if link.motion is not None and link.motion.has_position:
                points = np.concatenate(
                    [p.vertices for other in obj.subtree(link) for leaf in other.leaves() for p in leaf.pieces]
                )
                unit = link.motion.direction / np.linalg.norm(link.motion.direction)
                offsets = points - link.motion.origin
                across = np.linalg.norm(offsets - np.outer(offsets @ unit, unit), axis=1)
                size = np.linalg.norm(np.ptp(points, axis=0))
                assert across.min() < 0.5 * size + 0.05, link.name


@pytest.mark.parametrize("name", family_names())
def test_a_family_has_a_description_and_a_canonical_category(name: str) -> None:
    build = family_builder(name)
    assert build.__doc__
    category = build(spec(name, 0).draw("shape")).category
    assert canonical_category(category) == category


def test_all_motion_types_occur() -> None:
    seen: Counter[MotionType] = Counter()
    for name in family_names():
        for index in range(5):
            obj = built(name, index)
            seen.update(_motion_type(link, link.motion) for link in obj.links if link.motion is not None)
            seen[MotionType.FIXED] += any(len(list(link.leaves())) > 1 for link in obj.links)
            seen[MotionType.NONE] += sum(link.parent is not None for link in obj.links) > 1
    assert set(seen) == set(MotionType)
    assert min(seen.values()) >= 3


def test_at_least_five_families_have_screws() -> None:
    screwing = set()
    for name in family_names():
        for index in range(12):
            obj = family_builder(name)(spec(name, index).draw("shape"))
            if any(link.motion is not None and link.motion.rotates for link in obj.links):
                screwing.add(name)
                break
        if len(screwing) == 5:
            return
    pytest.fail(f"only {sorted(screwing)}")


def test_labelled_and_unlabelled_shapes_differ_and_overlap() -> None:
    def width(parameter_range: ParameterRange, index: int) -> float:
        obj = family_builder("safe")(Draw(np.random.default_rng(index), parameter_range))
        low, high = obj.bounds()
        return float((high - low)[1])

    labelled = [width(ParameterRange.LABELLED, index) for index in range(60)]
    unlabelled = [width(ParameterRange.UNLABELLED, index) for index in range(60)]
    assert np.mean(unlabelled) > np.mean(labelled) + 0.05
    assert min(unlabelled) < max(labelled)


def test_an_unknown_family_is_refused() -> None:
    with pytest.raises(InputError, match="unknown family 'spaceship'"):
        family_builder("spaceship")


def _motion_type(link: Link, motion: Motion) -> MotionType:
    kind = JointKind.REVOLUTE if motion.is_hinge else JointKind.SCREW if motion.rotates else JointKind.PRISMATIC
    pieces = [piece for leaf in link.leaves() for piece in leaf.pieces]
    meshes = _core.Meshes([p.vertices for p in pieces], [p.faces for p in pieces])
    centers, axes, halves = _core.fit_boxes(meshes, [list(range(len(pieces)))])
    direction = motion.direction / np.linalg.norm(motion.direction)
    return motion_type(Joint(kind, direction, motion.origin), Box(centers[0], axes[0], halves[0]), UP)
