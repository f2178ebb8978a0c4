"""`Meshes` refuses what is no mesh, by name, and takes whatever is one."""

from __future__ import annotations

import numpy as np
import pytest
from solids import BOX, DEGENERATE, MeshArrays, meshes

from kinmo import _core


def test_areas_are_those_of_the_faces() -> None:
    np.testing.assert_allclose(meshes(BOX, DEGENERATE["rectangle"], DEGENERATE["line"]).areas(), [22.0, 2.0, 0.0], atol=1e-12)
    assert len(meshes(BOX, BOX)) == 2


@pytest.mark.parametrize("part", DEGENERATE.values(), ids=DEGENERATE)
def test_degenerate_meshes_are_taken(part: MeshArrays) -> None:
    assert np.isfinite(meshes(part).areas()).all()


def test_unused_vertices_are_ignored() -> None:
    stray = (np.concatenate([BOX[0], [[100.0, 0, 0]]]), BOX[1])
    _, _, half_extents = _core.fit_boxes(meshes(stray))
    np.testing.assert_allclose(half_extents, [[1.5, 1.0, 0.5]])


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        ([[0, 0, np.nan]] * 3, [[0, 1, 2]], r"vertices\[1\]: row 0 is not finite"),
        ([[0, np.inf, 0]] * 3, [[0, 1, 2]], r"vertices\[1\]: row 0 is not finite"),
        ([[0, 0, 0]] * 3, [[0, 1, 3]], r"faces\[1\]: row 0 .* outside 0\.\.3"),
        ([[0, 0]] * 3, [[0, 1, 2]], r"vertices\[1\]: shape \[3, 2\], expected \[N, 3\]"),
        ([[0, 0, 0]] * 4, [[0, 1, 2, 3]], r"faces\[1\]: shape \[1, 4\], expected \[N, 3\]"),
        (np.zeros((0, 3)), [[0, 1, 2]], r"vertices\[1\]: empty"),
        ([[0, 0, 0]] * 3, np.zeros((0, 3)), r"faces\[1\]: empty"),
    ],
)
def test_what_is_no_mesh_is_refused_by_name(vertices: object, faces: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        _core.Meshes([BOX[0], np.array(vertices, float)], [BOX[1], np.array(faces, np.uint32)])


def test_as_many_vertex_arrays_as_face_arrays_are_wanted() -> None:
    with pytest.raises(ValueError, match="faces: 1 arrays, but vertices has 2"):
        _core.Meshes([BOX[0], BOX[0]], [BOX[1]])


@pytest.mark.parametrize("fit", [_core.fit_boxes, _core.fit_symmetric_boxes, _core.find_symmetries])
@pytest.mark.parametrize(
    ("groups", "name"), [([[0], []], r"groups\[1\]: empty"), ([[1]], r"groups\[0\]"), ([[0], [-1]], r"groups\[1\]")]
)
def test_bad_groups_are_refused_by_name(fit: object, groups: list[list[int]], name: str) -> None:
    with pytest.raises(ValueError, match=name):
        fit(meshes(BOX), groups)  # type: ignore[operator]
