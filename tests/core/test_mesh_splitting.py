"""Parts of a mesh."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_shapes import cabinet_shape

from kinmo.core.mesh_splitting import cut_mesh


@given(part=st.integers(0, 5), share=st.floats(-0.5, 1.5), axis=st.integers(0, 2))
def test_the_two_sides_of_a_plane_are_the_whole_mesh(part: int, share: float, axis: int) -> None:
    shape = cabinet_shape(0)[0]
    mesh = shape.leaf_mesh(shape.leaves[part % len(shape.leaves)])
    normal, heights = np.eye(3)[axis], mesh.vertices[:, axis]
    level = float(heights.min() + share * np.ptp(heights))
    above, below = cut_mesh(mesh, normal, level), cut_mesh(mesh, -normal, -level)
    in_plane = mesh.face_areas[np.all(np.abs(mesh.triangles[:, :, axis] - level) < 1e-7, axis=1)].sum()
    both = above.face_areas.sum() + below.face_areas.sum()
    assert both - mesh.face_areas.sum() == pytest.approx(0.0, abs=in_plane + 1e-6)
    assert (above.vertices[:, axis] >= level - 1e-7).all() and (below.vertices[:, axis] <= level + 1e-7).all()


def test_nothing_of_a_mesh_lies_above_a_plane_above_it() -> None:
    shape = cabinet_shape(0)[0]
    mesh = shape.leaf_mesh(shape.leaves[0])
    nothing = cut_mesh(mesh, np.array([0.0, 1.0, 0.0]), float(mesh.vertices[:, 1].max()) + 1.0)
    assert not len(nothing.faces)
    assert not len(cut_mesh(nothing, np.array([0.0, 1.0, 0.0]), 0.0).faces)
