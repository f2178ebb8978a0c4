"""Quirks of real files: they are as frequent as in real data and change nothing that matters."""

from __future__ import annotations

from collections import Counter
from copy import deepcopy

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinmo.core.shape import Mesh
from kinmo.io.readers import PARTNET_MOBILITY
from kinmo.synth.draw import Draw, ParameterRange
from kinmo.synth.families import family_builder, family_names
from kinmo.synth.generate import ShapeSpec, build_shape
from kinmo.synth.hierarchy_style import apply_hierarchy_style, flatten_hierarchy
from kinmo.synth.joint_quirks import add_joint_quirks
from kinmo.synth.mesh_quirks import SHEET_SHARE, add_mesh_quirks, as_sheet, flatten_thin_panels, subdivided
from kinmo.synth.primitives import box, rounded_box
from kinmo.synth.synth_object import JointType, Motion, SynthObject


def fresh(name: str, seed: int) -> SynthObject:
    return family_builder(name)(Draw(np.random.default_rng(seed)))


def draw(seed: int) -> Draw:
    return Draw(np.random.default_rng(seed))


def area(obj: SynthObject) -> float:
    pieces = [piece for leaf in obj.root.leaves() for piece in leaf.pieces]
    return sum(_area(piece) for piece in pieces)


def _area(piece: Mesh) -> float:
    a, b, c = (piece.vertices[piece.faces[:, i]] for i in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def test_quirks_are_as_frequent_as_in_real_files() -> None:
    joints: list[Motion] = []
    split_links = 0
    objects = [
        build_shape(ShapeSpec(name, index, 1, PARTNET_MOBILITY, ParameterRange.BOTH))
        for name in family_names()
        for index in range(6)
    ]
    for obj in objects:
        moving = [link for link in obj.links if link.motion is not None]
        joints += [link.motion for link in moving if link.motion is not None]
        split_links += sum(len(link.nodes) > 1 for link in moving)
    hinges = [joint for joint in joints if joint.is_hinge and not joint.no_limit]
    sliders = [joint for joint in joints if not joint.is_hinge]
    lengths = [abs(np.linalg.norm(joint.direction) - 1) for joint in joints]

    def share(marks: list[bool]) -> float:
        return sum(marks) / len(marks)

    assert 0.4 < share([joint.a > joint.b for joint in hinges]) < 0.7
    assert 0.1 < share([joint.a > joint.b for joint in sliders]) < 0.4
    assert 0.01 < share([not min(joint.a, joint.b) <= 1e-9 <= max(joint.a, joint.b) + 2e-9 for joint in hinges]) < 0.1
    assert 0.01 < share([length > 1e-3 for length in lengths]) < 0.08
    assert 0.03 < split_links / len(joints) < 0.25
    assert 0.05 < share([joint.no_limit for joint in joints]) < 0.35
    assert 0.005 < share([any(link.kind is JointType.JUNK for link in obj.links) for obj in objects]) < 0.12


@settings(max_examples=20)
@given(seed=st.integers(0, 10_000), name=st.sampled_from(["safe", "table", "microwave", "suitcase"]))
def test_hierarchy_styles_keep_geometry_and_links(seed: int, name: str) -> None:
    obj = fresh(name, seed)
    before = {link: sorted(len(p.faces) for leaf in link.leaves() for p in leaf.pieces) for link in obj.links}
    total = area(obj)
    apply_hierarchy_style(obj, draw(seed))
    obj.check()
    for link, counts in before.items():
        if link.motion is not None:
            assert sorted(len(p.faces) for leaf in link.leaves() for p in leaf.pieces) == counts
    assert area(obj) == pytest.approx(total)


def test_flat_hierarchies_have_one_leaf_per_link() -> None:
    obj = fresh("table", 3)
    flatten_hierarchy(obj, draw(0))
    obj.check()
    assert len(list(obj.root.leaves())) == len(obj.links)
    assert all(not child.children for child in obj.root.children)


@settings(max_examples=30)
@given(seed=st.integers(0, 10_000))
def test_joint_quirks_keep_the_motion(seed: int) -> None:
    obj = fresh("refrigerator", seed)
    obj.apply_rest_pose()
    obj.normalise(2.0)
    truth = [link.motion for link in obj.links]
    add_joint_quirks(obj, draw(seed))
    for before, link in zip(truth, obj.links, strict=True):
        if before is None or link.motion is None:
            continue
        flipped = float(before.direction @ link.motion.direction) < 0
        ends = [before.a, before.b]
        stated = [-link.motion.a, -link.motion.b] if flipped else [link.motion.a, link.motion.b]
        if before.is_hinge:
            turns = (np.array(stated) - ends) / 360.0
            np.testing.assert_allclose(turns, np.round(turns[0]), atol=1e-9)
            unit = before.direction / np.linalg.norm(before.direction)
            apart = np.cross(link.motion.origin - before.origin, unit)
            assert np.linalg.norm(apart) < 0.06
        else:
            assert stated[1] - stated[0] == pytest.approx(ends[1] - ends[0])
        cosine = before.direction @ link.motion.direction / np.linalg.norm(link.motion.direction)
        assert abs(float(cosine)) > np.cos(np.radians(3.01))


@settings(max_examples=15)
@given(seed=st.integers(0, 10_000))
def test_mesh_quirks_keep_the_surface(seed: int) -> None:
    obj = fresh("safe", seed)
    low, high = obj.bounds()
    before = area(deepcopy(obj))
    add_mesh_quirks(obj, draw(seed))
    np.testing.assert_allclose(obj.bounds(), (low, high), atol=1e-12)
    assert 0.9 * before < area(obj) < 2.1 * before


@given(st.permutations([0.05, 1.0, 2.0]), st.floats(-3.0, 3.0))
def test_a_thin_panel_becomes_a_sheet_at_its_middle(size: list[float], shift: float) -> None:
    panel = box(size, (shift, 0.0, 0.0))
    sheet = as_sheet(panel)
    thin = size.index(0.05)
    middle = 0.5 * (panel.vertices.min(axis=0) + panel.vertices.max(axis=0))
    np.testing.assert_allclose(sheet.vertices[:, thin], middle[thin], atol=1e-12)
    np.testing.assert_allclose(np.ptp(sheet.vertices, axis=0), np.where(np.arange(3) == thin, 0.0, size), atol=1e-12)
    assert _area(sheet) == pytest.approx(2.0 * 2.0)


def test_only_some_thin_panels_become_sheets() -> None:
    block = box((1, 0.5, 2))
    assert as_sheet(block) is block
    flat = total = 0
    for seed in range(60):
        obj = fresh("storage_furniture", seed)
        flatten_thin_panels(obj, draw(seed))
        thin = [np.ptp(piece.vertices, axis=0).min() == 0.0 for leaf in obj.root.leaves() for piece in leaf.pieces]
        flat, total = flat + sum(thin), total + len(thin)
    assert 0.1 * SHEET_SHARE < flat / total < 1.5 * SHEET_SHARE


@pytest.mark.parametrize("mesh", [box((1, 2, 3)), rounded_box((1, 2, 3), 0.3)])
def test_subdivision_keeps_area_and_shares_vertices(mesh: Mesh) -> None:
    fine = subdivided(mesh)
    assert len(fine.faces) == 4 * len(mesh.faces)
    assert _area(fine) == pytest.approx(_area(mesh))
    edges = np.sort(fine.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    uses = Counter(map(tuple, edges.tolist()))
    assert set(uses.values()) == {2}, "a closed mesh stays closed"
