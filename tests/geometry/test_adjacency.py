"""Exact distances between parts."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import numpy as np
import pytest
import trimesh
from brute_force import block, meshes_of, triangle_soup_distance
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kinmo import _core

SEEDS = st.integers(0, 2**32 - 1)


def soup(rng: np.random.Generator, faces: int) -> trimesh.Trimesh:
    """Triangles at random, some of them slivers, needles, points, flat against an axis, or twice there."""
    corners = rng.uniform(-1, 1, (faces, 3, 3)) * rng.choice([0.05, 0.3, 1.0], (faces, 1, 1)) + rng.uniform(
        -1, 1, (faces, 1, 3)
    )
    for triangle in corners:
        kind = rng.integers(0, 8)
        if kind == 0:
            triangle[2] = triangle[1]
        elif kind == 1:
            triangle[:] = triangle[0]
        elif kind == 2:
            triangle[2] = (triangle[0] + triangle[1]) / 2
        elif kind == 3:
            triangle[:, rng.integers(3)] = 0.25
    corners[-1] = corners[0]
    return trimesh.Trimesh(corners.reshape(-1, 3), np.arange(3 * faces).reshape(-1, 3), process=False)


def distance_of(a: trimesh.Trimesh, b: trimesh.Trimesh) -> tuple[float, np.ndarray, np.ndarray]:
    _, distances, first, second = _core.part_distances(meshes_of(a, b))
    return float(distances[0]), first[0], second[0]


@settings(max_examples=30)
@given(SEEDS, st.integers(1, 4), st.integers(1, 4), st.sampled_from([0.0, 1.0, 2.5]))
def test_distances_equal_those_of_all_pairs_of_triangles(seed: int, first: int, second: int, apart: float) -> None:
    rng = np.random.default_rng(seed)
    a, b = soup(rng, first), soup(rng, second)
    b.apply_translation([apart, 0, 0])
    distance, near_a, near_b = distance_of(a, b)
    assert distance == pytest.approx(triangle_soup_distance(a.triangles, b.triangles), abs=1e-9)
    assert np.linalg.norm(near_a - near_b) == pytest.approx(distance, abs=1e-12)
    for point, solid in ((near_a, a), (near_b, b)):
        corner = np.repeat(point[None, None], 3, axis=1)
        assert triangle_soup_distance(corner, solid.triangles) < 1e-9


@settings(max_examples=40)
@given(SEEDS, st.sampled_from([1e-8, 1.0, 1e8]), st.sampled_from([0.0, 1e6]))
def test_distances_do_not_depend_on_order_pose_and_scale(seed: int, scale: float, offset: float) -> None:
    rng = np.random.default_rng(seed)
    a, b = soup(rng, 8), soup(rng, 8)
    b.apply_translation([2.0, 0, 0])
    expected, _, _ = distance_of(a, b)
    assert distance_of(b, a)[0] == pytest.approx(expected, abs=1e-14)
    turn = Rotation.random(random_state=seed % 2**31).as_matrix()
    moved = [solid.copy() for solid in (a, b)]
    for solid in moved:
        solid.vertices = (solid.vertices @ turn.T + offset) * scale
    assert distance_of(*moved)[0] / scale == pytest.approx(expected, abs=1e-9 if offset else 1e-13)


def test_a_part_inside_another_is_as_far_as_its_surface() -> None:
    shell, inner = trimesh.creation.icosphere(2, 1.0), trimesh.creation.icosphere(2, 0.25)
    assert 0.7 < distance_of(shell, inner)[0] < 0.75


def test_crossing_and_touching_parts_are_exactly_zero_apart() -> None:
    body = block((1, 1, 1), (0, 0, 0))
    assert distance_of(body, block((1, 1, 1), (0.3, 0.2, 0.1)))[0] == 0
    assert distance_of(body, block((1, 1, 1), (1.0, 0.2, 0.1)))[0] == 0
    inside_out = block((1, 1, 1), (1.0, 1.0, 1.0))
    inside_out.invert()
    assert distance_of(body, inside_out)[0] == 0


def test_a_group_is_as_near_as_its_nearest_member() -> None:
    rng = np.random.default_rng(3)
    solids = [soup(rng, 5) for _ in range(6)]
    for index, solid in enumerate(solids):
        solid.apply_translation([3.0 * index, 0, 0])
    meshes = meshes_of(*solids)
    pairs, single, _, _ = _core.part_distances(meshes)
    assert pairs.tolist() == [[a, b] for a in range(6) for b in range(a + 1, 6)]
    table = {tuple(pair): distance for pair, distance in zip(pairs.tolist(), single, strict=True)}
    groups = [[0, 3], [1], [2, 4, 5]]
    pairs, grouped, _, _ = _core.part_distances(meshes, groups)
    for (a, b), distance in zip(pairs.tolist(), grouped, strict=True):
        members = [tuple(sorted((i, j))) for i in groups[a] for j in groups[b]]
        assert distance == min(table[member] for member in members)


def test_pairs_beyond_the_largest_distance_are_left_out() -> None:
    meshes = meshes_of(*(block((1, 1, 1), (1.5 * index, 0, 0), cuts=0) for index in range(4)))
    assert _core.part_distances(meshes, max_distance=0.5)[0].tolist() == [[0, 1], [1, 2], [2, 3]]
    assert len(_core.part_distances(meshes, max_distance=0.499)[0]) == 0
    chosen = np.array([[3, 0], [2, 1]], np.uint32)
    pairs, distances, _, _ = _core.part_distances(meshes, pairs=chosen)
    assert pairs.tolist() == chosen.tolist()
    np.testing.assert_allclose(distances, [3.5, 0.5], atol=1e-15)


def test_what_touches_but_for_rounding_is_near_enough_for_the_least_distance() -> None:
    plate = np.array([[0, 0, 1], [1, 0, 1], [0, 1, 1]], float)
    raised = plate + [0, 0, 2.0**-52]
    meshes = _core.Meshes([plate, raised], [np.array([[0, 1, 2]], np.uint32)] * 2)
    assert _core.part_distances(meshes)[1].tolist() == [0.0]
    assert _core.part_distances(meshes, max_distance=0.0)[1].tolist() == [0.0]


def test_arguments_are_refused_by_name() -> None:
    meshes = meshes_of(block((1, 1, 1), (0, 0, 0)), block((1, 1, 1), (2, 0, 0)))
    with pytest.raises(ValueError, match=r"^pairs: row 0 has an index outside 0..2"):
        _core.part_distances(meshes, pairs=np.array([[0, 2]], np.uint32))
    with pytest.raises(ValueError, match=r"^pairs: shape"):
        _core.part_distances(meshes, pairs=np.zeros((2, 3), np.uint32))
    with pytest.raises(ValueError, match=r"^pairs: row 0 pairs group 1 with itself"):
        _core.part_distances(meshes, pairs=np.array([[1, 1]], np.uint32))
    with pytest.raises(ValueError, match=r"^groups\[1\]: empty"):
        _core.part_distances(meshes, [[0], []])
    with pytest.raises(ValueError, match=r"^max_distance"):
        _core.part_distances(meshes, max_distance=float("nan"))


EVERYTHING = """
import json
import numpy as np
from kinmo import _core
rng = np.random.default_rng(0)
corners = rng.uniform(-1, 1, (12, 1, 3)) + rng.uniform(-0.3, 0.3, (12, 90, 3))
meshes = _core.Meshes(list(corners), [np.arange(90, dtype=np.uint32).reshape(-1, 3)] * 12)
pairs = np.array([[a, b] for a in range(12) for b in range(a)], np.uint32)
regions = _core.interaction_regions(corners, pairs)
kinds = np.arange(9, dtype=np.uint8) % 3
lines = np.eye(3)[np.arange(9) % 3], corners[0, :9]
travels = _core.sweep(meshes, [0, 1], [2, 3, 4], kinds, *lines, np.full(9, -1.0), np.full(9, 1.0))
moved = _core.move_points(corners[0].astype(np.float32), kinds, *lines, np.ones((9, 2)), np.ones((9, 2)))
boxes = _core.fit_boxes(meshes)
found = [_core.box_iou(*boxes, *(values[::-1].copy() for values in boxes)), *_core.closest_points(meshes, [0, 1], corners[0])]
found += [*_core.part_distances(meshes), regions.centroids, regions.samples, regions.weights, *travels, moved]
print(json.dumps([array.tobytes().hex() for array in found]))
"""


def test_results_do_not_depend_on_the_number_of_threads() -> None:
    def outcome(threads: int) -> list[str]:
        environment = {**os.environ, "RAYON_NUM_THREADS": str(threads), "PYTHONPATH": os.pathsep.join(sys.path)}
        command = [sys.executable, "-c", EVERYTHING]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        return list(json.loads(done.stdout))

    assert outcome(1) == outcome(3)
