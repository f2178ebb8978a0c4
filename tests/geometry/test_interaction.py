"""Interaction regions against SciPy's Voronoi diagram of the whole scene."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import scipy_ibs
import trimesh
from brute_force import block
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kinmo import _core

PAIR = np.array([[0, 1]], np.uint32)
AGREEMENT = 0.01


def samples(solid: trimesh.Trimesh, count: int = 256, seed: int = 0) -> np.ndarray:
    return np.asarray(trimesh.sample.sample_surface(solid, count, seed=seed)[0])


def touching_pairs() -> list[tuple[str, np.ndarray]]:
    """Moving and reference samples [2, n, 3]: doors, drawers, knobs, lids, handles and a wheel."""
    wheel = trimesh.creation.cylinder(0.3, 0.1)
    solids = {
        "door in front of a body": (block((1, 2, 0.04), (0, 0, 0.52)), block((1, 2, 1), (0, 0, 0))),
        "handle on a door": (block((0.05, 0.3, 0.05), (0.4, 0, 0.045)), block((1, 2, 0.04), (0, 0, 0))),
        "drawer under a board": (block((1, 0.3, 1), (0, 0, 0)), block((1.1, 0.05, 1.1), (0, 0.175, 0))),
        "lid on a pot": (trimesh.creation.cylinder(0.5, 0.05), block((1, 1, 0.6), (0, 0, -0.325))),
        "wheel on an axle": (wheel, trimesh.creation.cylinder(0.03, 0.6)),
        "ball in a corner": (trimesh.creation.icosphere(3, 0.3), block((1, 1, 0.1), (0, 0, -0.35))),
    }
    return [(name, np.stack([samples(a), samples(b, seed=1)])) for name, (a, b) in solids.items()]


@pytest.mark.parametrize(("name", "points"), touching_pairs())
def test_regions_agree_with_the_whole_voronoi_diagram(name: str, points: np.ndarray) -> None:
    expected = scipy_ibs.interaction_region(*points)
    region = _core.interaction_regions(points, PAIR)
    assert region.scored[0], name
    assert np.linalg.norm(region.centroids[0] - expected.centroid) < AGREEMENT * expected.diagonal
    scores = np.zeros(points.shape[0] * points.shape[1])
    scores[region.samples[:, 0] * points.shape[1] + region.samples[:, 1]] = region.weights
    scores *= expected.diagonal**2
    assert np.abs(scores - expected.scores).sum() < 0.1 * expected.scores.sum()
    assert region.offsets.tolist() == [0, len(region.weights)]
    assert (region.weights > 0).all()


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1), st.sampled_from([1e-8, 1.0, 1e8]))
def test_regions_turn_and_scale_with_the_shape(seed: int, scale: float) -> None:
    name, points = touching_pairs()[seed % 6]
    expected = _core.interaction_regions(points, PAIR).centroids[0]
    turn = Rotation.random(random_state=seed % 2**31).as_matrix()
    moved = (points @ turn.T + 1000.0) * scale
    back = (_core.interaction_regions(moved, PAIR).centroids[0] / scale - 1000.0) @ turn
    # The diagonal is that of an axis-aligned box: scores change a little when the shape turns.
    diagonal = np.linalg.norm(np.ptp(points.reshape(-1, 3), axis=0))
    assert np.linalg.norm(back - expected) < 0.05 * diagonal, name


def test_single_precision_samples_give_the_same_region() -> None:
    _, points = touching_pairs()[1]
    single = _core.interaction_regions(points.astype(np.float32), PAIR)
    np.testing.assert_allclose(single.centroids, _core.interaction_regions(points, PAIR).centroids, atol=1e-4)


def test_a_group_has_the_samples_of_its_members() -> None:
    _, (moving, reference) = touching_pairs()[0]
    halves = np.stack([moving[:128], moving[128:], reference[:128], reference[128:]])
    whole = _core.interaction_regions(np.stack([moving, reference]), PAIR)
    grouped = _core.interaction_regions(halves, PAIR, [[0, 1], [2, 3]])
    np.testing.assert_array_equal(grouped.centroids, whole.centroids)
    number = grouped.samples[:, 0] * 128 + grouped.samples[:, 1]
    np.testing.assert_array_equal(number, whole.samples[:, 0] * 256 + whole.samples[:, 1])


def test_what_touches_is_within_a_hundredth_of_the_diagonal() -> None:
    grid = np.stack(np.meshgrid(np.linspace(0, 1, 16), np.linspace(0, 1, 16), [0.0]), axis=-1).reshape(-1, 3)
    near, far = (_core.interaction_regions(np.stack([grid, grid + [0, 0, gap]]), PAIR) for gap in (0.014, 0.05))
    assert (near.touching[0], far.touching[0]) == (True, False)
    np.testing.assert_allclose(far.centroids[0], [0.5, 0.5, 0.0], atol=0.03)


def test_clouds_that_no_ridge_scores_fall_back_to_the_nearest_pairs() -> None:
    points = np.zeros((2, 5, 3))
    points[1] = [1.0, 0.0, 0.0]
    region = _core.interaction_regions(points, PAIR)
    assert np.isfinite(region.centroids).all()
    if not region.scored[0]:
        np.testing.assert_allclose(region.centroids[0], [0.5, 0, 0], atol=1e-12)
    coincident = _core.interaction_regions(np.ones((2, 5, 3)), PAIR)
    np.testing.assert_allclose(coincident.centroids[0], [1, 1, 1], atol=1e-6)


def test_arguments_are_refused_by_name() -> None:
    points = np.zeros((2, 4, 3))
    with pytest.raises(ValueError, match=r"^points: shape"):
        _core.interaction_regions(points[0], PAIR)
    with pytest.raises(ValueError, match=r"^points: shape"):
        _core.interaction_regions(points[:, :0], PAIR)
    with pytest.raises(ValueError, match=r"^points: not finite"):
        _core.interaction_regions(points * np.nan, PAIR)
    with pytest.raises(ValueError, match=r"^pairs: row 0"):
        _core.interaction_regions(points, np.array([[0, 2]], np.uint32))
    with pytest.raises(ValueError, match=r"^groups\[0\]: index 2"):
        _core.interaction_regions(points, PAIR, [[2], [0]])


@pytest.mark.real
def test_the_door_of_a_real_cabinet_meets_its_body_at_its_back(real_objects: list[Path]) -> None:
    folder = next((folder for folder in real_objects if folder.name == "40147"), None)
    if folder is None:
        pytest.skip("object 40147 is absent")
    bodies = json.loads((folder / "mobility_v2.json").read_text())
    door = next(body for body in bodies if body["joint"] == "hinge")
    parts = {part["id"] for part in door["parts"]}
    clouds = [samples(_mesh_of(folder, parts, own), 1024) for own in (True, False)]
    centroid = _core.interaction_regions(np.stack(clouds), PAIR).centroids[0]
    assert centroid[2] == pytest.approx(0.386, abs=0.02)


def _mesh_of(folder: Path, parts: set[int], own: bool) -> trimesh.Trimesh:
    """All leaves that are (or are not) below the given nodes of the hierarchy."""
    names: list[str] = []
    pending = [(node, False) for node in json.loads((folder / "result.json").read_text())]
    while pending:
        node, below = pending.pop()
        below = below or node["id"] in parts
        pending.extend((child, below) for child in node.get("children", []))
        names += node.get("objs", []) if below == own and not node.get("children") else []
    files = [folder / "textured_objs" / f"{name}.obj" for name in names]
    return trimesh.util.concatenate([trimesh.load(file, force="mesh", skip_materials=True) for file in files])
