"""Hypotheses and what speaks for them."""

import numpy as np
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from evidence_cabinet import DOOR, DRAWER, FRAME, KNOB, UP, scene
from kinmo import _core
from kinmo.features.candidate_features import PRISMATIC, REVOLUTE, Evidence, Scene, gather, see_units
from kinmo.features.round_pieces import MOST, RoundPieces

UNITS = [(FRAME,), (DOOR,), (KNOB,), (DRAWER,), (DOOR, KNOB)]
STILL = gather(scene(), UNITS)


@settings(max_examples=15)
@given(st.floats(-np.pi, np.pi), st.integers(0, 100), st.booleans())
def test_nothing_depends_on_how_the_object_is_turned(angle: float, seed: int, freely: bool) -> None:
    turn = Rotation.random(rng=np.random.default_rng(seed)) if freely else Rotation.from_rotvec(angle * UP)
    turned = gather(scene(turn.as_matrix()), UNITS)
    np.testing.assert_allclose(turned.unit_features, STILL.unit_features, atol=5e-3)
    np.testing.assert_allclose(turned.centers, STILL.centers @ turn.as_matrix().T, atol=1e-5)
    assert np.median(counterpart_errors(turned, turn.as_matrix())) < 0.02


def counterpart_errors(turned: Evidence, turn: np.ndarray) -> list[float]:
    """For every hypothesis of the cabinet at rest, how far the features of the same motion of the turned one are from its own.

    Of lines that lie within the tolerance of merging another one may have been kept: not every hypothesis has a counterpart.
    """
    errors = []
    for unit in range(len(UNITS)):
        ours, theirs = STILL.rows(unit), turned.rows(unit)
        directions, pivots = STILL.directions[ours] @ turn.T, STILL.pivots[ours] @ turn.T
        for kind, direction, pivot, features in zip(STILL.kinds[ours], directions, pivots, STILL.features[ours], strict=True):
            same = (turned.kinds[theirs] == kind) & (np.abs(turned.directions[theirs] @ direction) > 1 - 1e-5)
            same &= np.linalg.norm(turned.pivots[theirs] - pivot, axis=1) < 5e-3
            errors.append(np.abs(turned.features[theirs][same] - features).max(axis=1).min() if same.any() else np.inf)
    return errors


def hypothesis_near(kind: int, unit: int, direction: tuple[float, ...], point: tuple[float, ...]) -> int:
    """Row (within the unit) of the hypothesis nearest to an axis."""
    rows = STILL.rows(unit)
    offset = np.array(point) - STILL.pivots[rows]
    away = np.linalg.norm(np.cross(offset, STILL.directions[rows]), axis=1)
    parallel = np.abs(STILL.directions[rows] @ np.array(direction)) > 0.99
    return int(np.argmin(np.where(parallel & (STILL.kinds[rows] == kind), away, np.inf)))


def test_the_true_joints_are_among_the_hypotheses() -> None:
    hinge = STILL.rows(1).start + hypothesis_near(REVOLUTE, 1, (0, 1, 0), (-0.23, 0, 0.15))
    assert np.linalg.norm(STILL.pivots[hinge][[0, 2]] - [-0.23, 0.15]) < 0.03
    slide = STILL.rows(3).start + hypothesis_near(PRISMATIC, 3, (0, 0, 1), (0, 0, 0))
    assert abs(STILL.directions[slide][2]) > 0.99


def test_what_hangs_on_a_part_alone_moves_with_it() -> None:
    cabinet = scene()
    assert cabinet.surroundings([DOOR]) == ([FRAME, DRAWER], [KNOB])
    assert cabinet.surroundings([DRAWER]) == ([FRAME, DOOR, KNOB], [])
    assert cabinet.surroundings([KNOB])[1] == []


def test_evidence_survives_the_store() -> None:
    kept = Evidence.of(STILL.arrays())
    np.testing.assert_array_equal(kept.features, STILL.features)
    np.testing.assert_array_equal(kept.offsets, STILL.offsets)
    np.testing.assert_allclose(kept.directions, STILL.directions, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(kept.directions, axis=1), 1.0)


def test_all_evidence_is_finite_even_for_a_part_that_stands_alone() -> None:
    alone = gather(scene(), [(FRAME, DOOR, KNOB, DRAWER)])
    for found in (STILL, alone):
        assert np.isfinite(found.features).all()
        assert np.isfinite(found.unit_features).all()
    assert STILL.features.shape[1] == alone.features.shape[1]


def test_what_forms_a_body_does_not_show_in_the_evidence_of_parts() -> None:
    leaves = [(FRAME,), (DOOR,), (KNOB,), (DRAWER,)]
    sizes = np.array([unit.minimum.half_extents for unit in see_units(scene(), leaves)])
    bare, annotated = gather(scene(), leaves, sizes), gather(scene(), [*leaves, (DOOR, KNOB), (FRAME, DRAWER)], sizes)
    np.testing.assert_array_equal(annotated.unit_features[: len(leaves)], bare.unit_features)
    np.testing.assert_array_equal(annotated.features[: len(bare.features)], bare.features)


def test_units_may_be_looked_at_one_after_another() -> None:
    sizes = np.array([unit.minimum.half_extents for unit in see_units(scene(), UNITS)])
    joined = gather(scene(), UNITS[:2], sizes).joined(gather(scene(), UNITS[2:], sizes))
    for name, values in STILL.arrays().items():
        np.testing.assert_array_equal(joined.arrays()[name], values)


def test_a_door_hung_left_differs_from_one_hung_right() -> None:
    """Mirrored, the cabinet is the same but for its hand: so are its features."""
    mirrored = gather(scene(np.diag([-1.0, 1.0, 1.0])), UNITS)
    left, right = ((x, 0.0, 0.15) for x in (-0.23, 0.23))
    here = STILL.features[STILL.rows(1)][hypothesis_near(REVOLUTE, 1, (0, 1, 0), left)]
    there = STILL.features[STILL.rows(1)][hypothesis_near(REVOLUTE, 1, (0, 1, 0), right)]
    assert np.abs(here - there).max() > 0.5
    rows = mirrored.rows(1)
    away = np.linalg.norm((mirrored.pivots[rows] - right)[:, [0, 2]], axis=1)
    upright = (np.abs(mirrored.directions[rows][:, 1]) > 0.99) & (mirrored.kinds[rows] == REVOLUTE)
    same_door = mirrored.features[rows][np.argmin(np.where(upright, away, np.inf))]
    differing = np.flatnonzero(np.abs(same_door - here) > 0.05)
    np.testing.assert_allclose(same_door[differing], -here[differing], atol=0.05)
    assert len(differing) == 2


def test_a_pin_that_a_part_touches_gives_it_a_line_to_turn_about() -> None:
    """Closed blades touch all along, and the screw is at no edge of either: boxes and contact have other lines than its."""
    upper, lower, screw, post = range(4)
    blades = scissors(screw_at=(0.1, 0.03))
    found = gather(blades, [(upper,), (lower,), (screw,), (post,)])
    for unit in (upper, lower):
        rows = found.rows(unit)
        about = (found.kinds[rows] == REVOLUTE) & (np.abs(found.directions[rows] @ UP) > 0.999)
        away = np.linalg.norm((found.pivots[rows] - [0.1, 0.0, 0.03])[:, [0, 2]], axis=1)
        assert (about & (away < 1e-3)).sum() == 1
        assert np.sort(away[about])[1] > 0.02
    assert len(blades.round_pieces) == 2
    units = see_units(blades, [[upper], [screw], [lower, screw]])
    assert [(len(unit.own_round), len(unit.next_round)) for unit in units] == [(0, 1), (1, 0), (1, 0)]


def test_of_many_round_pieces_those_next_to_the_contact_are_taken() -> None:
    leaves = np.zeros(20, int)
    middles = np.column_stack([np.arange(20.0), np.zeros(20), np.zeros(20)])
    many = RoundPieces(leaves, middles, np.tile(UP, (20, 1)), np.full(20, 0.1), np.full(20, 0.2))
    kept = many.nearest_to(np.array([12.0, 5.0, 0.0]))
    assert len(kept) == MOST
    assert kept.middles[:, 0].tolist() == list(range(12 - MOST // 2, 12 + MOST // 2))


def scissors(screw_at: tuple[float, float]) -> Scene:
    """Two flat blades on each other, a screw through both, and a post beside them."""
    x, z = screw_at
    upright = trimesh.transformations.rotation_matrix(np.pi / 2, [1.0, 0.0, 0.0])
    made = [
        trimesh.creation.box((0.8, 0.02, 0.08)).apply_translation([0.0, 0.01, 0.0]),
        trimesh.creation.box((0.8, 0.02, 0.08)).apply_translation([0.02, -0.01, 0.01]),
        trimesh.creation.cylinder(0.012, 0.06, sections=24, transform=upright).apply_translation([x, 0.0, z]),
        trimesh.creation.cylinder(0.02, 0.3, sections=24, transform=upright).apply_translation([0.0, 0.0, 0.3]),
    ]
    meshes = _core.Meshes([np.array(m.vertices) for m in made], [np.array(m.faces, np.uint32) for m in made])
    points, normals, _ = _core.sample_surface(meshes, 512, 3)
    return Scene.of(meshes, points, normals, meshes.areas(), UP)
