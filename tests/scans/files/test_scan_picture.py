"""Pictures of scans: everything is drawn where the camera sees it."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo.core.joint import JointKind
from kinmo.scans.files.scan_picture import EDGES, MARGIN, SIZE, ScanView, scan_picture

SIGNS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
ROTATION = Rotation.from_rotvec([0.3, -0.5, 0.2]).as_matrix()
HALF, MIDDLE = np.array([0.2, 0.4, 0.1]), np.array([0.1, -0.2, 2.0])
CORNERS = MIDDLE + (SIGNS * HALF) @ ROTATION.T
UNKNOWN = np.full(3, np.nan)
VIEW = ScanView(
    points=CORNERS,
    parts=np.ones(8, int),
    centers=np.stack([UNKNOWN, MIDDLE]),
    rotations=np.stack([np.full((3, 3), np.nan), ROTATION]),
    half_extents=np.stack([UNKNOWN, HALF]),
    kinds=(JointKind.REVOLUTE,),
    directions=ROTATION[:, 1][None],
    pivots=CORNERS[:1],
)
"""The corners of a box, the box as the only found part, and a hinge along its longest edge."""


def drawn(picture: str, kind: str) -> list[NDArray[np.float64]]:
    """Points [n, 2] of all paths of a kind: `h0` for dots, `L` for edges."""
    paths = re.findall(r'<path d="([^"]*)"', picture)
    return [np.array(re.findall(r"[ML]([-\d.]+) ([-\d.]+)", path), float) for path in paths if kind in path]


def drawn_axis(picture: str) -> NDArray[np.float64]:
    """Ends [2, 2] of the drawn axis."""
    found = re.findall(r'x1="([-\d.]+)" y1="([-\d.]+)" x2="([-\d.]+)" y2="([-\d.]+)"', picture)
    return np.array(found[-1], float).reshape(2, 2)


def distance_to_line(place: NDArray[np.float64], ends: NDArray[np.float64]) -> float:
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    return float(abs(np.cross(np.append(place - ends[0], 0.0), np.append(along, 0.0))[2]))


def test_the_corners_of_a_box_are_drawn_where_points_are() -> None:
    picture = scan_picture([VIEW], "a box")
    (dots,), (edges,) = drawn(picture, "h0"), drawn(picture, "L")
    np.testing.assert_allclose(edges.reshape(-1, 2, 2), dots[np.array(EDGES)], atol=0.11)
    assert len({tuple(sorted(edge)) for edge in EDGES}) == 12
    assert all(np.abs(SIGNS[a] - SIGNS[b]).sum() == 2 for a, b in EDGES), "no diagonals"


def test_the_picture_is_a_perspective_projection() -> None:
    (dots,) = drawn(scan_picture([VIEW], "a box"), "h0")
    seen = CORNERS[:, :2] / CORNERS[:, 2:]
    scale = np.ptp(dots, axis=0) / np.ptp(seen, axis=0)
    assert scale[0] == pytest.approx(scale[1], rel=0.01)
    np.testing.assert_allclose(dots - dots.mean(axis=0), scale[0] * (seen - seen.mean(axis=0)), atol=0.5)
    assert dots.min() >= MARGIN * SIZE - 0.1 and dots.max() <= (1 - MARGIN) * SIZE + 0.1


def test_a_hinge_is_drawn_along_its_edge_and_direction() -> None:
    picture = scan_picture([VIEW], "a box")
    (dots,) = drawn(picture, "h0")
    ends, edge = drawn_axis(picture), dots[[0, 2]]  # from -y to +y of the box
    assert all(distance_to_line(corner, ends) < 0.3 for corner in edge)
    assert (ends[1] - ends[0]) @ (edge[1] - edge[0]) > np.linalg.norm(edge[1] - edge[0]) ** 2, "and is longer than the box"


def test_the_axis_of_a_slider_passes_the_middle_of_its_part() -> None:
    at_middle = replace(VIEW, points=np.vstack([CORNERS, MIDDLE]), parts=np.ones(9, int))
    picture = scan_picture([replace(at_middle, kinds=(JointKind.PRISMATIC,), pivots=UNKNOWN[None])], "a drawer")
    (dots,) = drawn(picture, "h0")
    assert distance_to_line(dots[-1], drawn_axis(picture)) < 0.3


def test_unknown_boxes_and_axes_are_not_drawn() -> None:
    nothing = replace(VIEW, centers=np.full((2, 3), np.nan), directions=UNKNOWN[None])
    picture = scan_picture([nothing], "nothing")
    assert not drawn(picture, "L") and "<line" not in picture


def test_views_side_by_side_have_one_scale() -> None:
    farther = replace(VIEW, points=VIEW.points * [1.0, 1.0, 2.0])
    one, other = drawn(scan_picture([VIEW, farther], "two"), "h0")
    assert np.ptp(other, axis=0) == pytest.approx(np.ptp(one, axis=0) / 2, rel=0.02)


def test_boxes_fit_into_the_picture_unless_they_are_far_too_large() -> None:
    seen = replace(VIEW, points=CORNERS[:4], parts=np.ones(4, int))
    (edges,) = drawn(scan_picture([seen], "half of a box"), "L")
    assert edges.min() >= MARGIN * SIZE - 0.1 and edges.max() <= (1 - MARGIN) * SIZE + 0.1
    vast = replace(VIEW, half_extents=VIEW.half_extents * 1.9)
    (dots,) = drawn(scan_picture([VIEW, vast], "two views"), "h0")[:1]
    assert np.ptp(dots, axis=0).max() >= 0.5 * (1 - 2 * MARGIN) * SIZE - 0.1, "the points fill half of the picture"


def test_views_side_by_side_do_not_overlap() -> None:
    picture = scan_picture([VIEW, VIEW], "two views")
    found = re.findall(r'<svg x="(\d+)" width="(\d+)" height="(\d+)">', picture)
    assert found == [("0", str(SIZE), str(SIZE)), (str(SIZE),) * 3]


@pytest.mark.parametrize("is_found", [True, False])
def test_a_picture_does_not_depend_on_the_unit_of_length(is_found: bool) -> None:
    extents = np.stack([UNKNOWN, HALF if is_found else UNKNOWN])
    view = replace(VIEW, half_extents=extents)
    lengths = ("points", "centers", "half_extents", "pivots")
    thousandfold = replace(view, **{name: 1000.0 * getattr(view, name) for name in lengths})
    assert scan_picture([thousandfold], "a box") == scan_picture([view], "a box")
    assert np.linalg.norm(np.diff(drawn_axis(scan_picture([view], "a box")), axis=0)) > 0.1 * SIZE
