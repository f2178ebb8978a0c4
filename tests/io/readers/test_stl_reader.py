"""The reader of STL files, text and binary."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from gltf_files import box

import kinmo
from kinmo.core.errors import InputError


def test_the_solids_of_a_text_stl_are_the_parts(tmp_path: Path) -> None:
    facet = "facet normal 0 0 0\nouter loop\nvertex {0} 0 0\nvertex {0} 1 0\nvertex {0} 0 1\nendloop\nendfacet\n"
    solids = "".join(f"solid {name}\n{facet.format(i)}endsolid {name}\n" for i, name in enumerate(["Door", "", "Door"]))
    (tmp_path / "a.stl").write_text(solids)
    assert sorted(part.name for part in kinmo.load(tmp_path / "a.stl").parts[1:]) == ["", "Door", "Door"]


def test_vertices_of_an_stl_file_are_shared(tmp_path: Path) -> None:
    trimesh.util.concatenate([box((1, 1, 1)), box((1, 1, 1), (3, 0, 0))]).export(tmp_path / "a.stl")
    assert [len(mesh.vertices) for mesh in kinmo.load(tmp_path / "a.stl").meshes()] == [8, 8]


@pytest.mark.parametrize(("length", "got"), [(300, "1284 bytes, as its header says, got 300"), (40, "an STL file")])
def test_an_stl_file_that_is_cut_off_is_an_error(length: int, got: str, tmp_path: Path) -> None:
    trimesh.util.concatenate([box((1, 1, 1)), box((1, 1, 1), (3, 0, 0))]).export(tmp_path / "a.stl")
    (tmp_path / "a.stl").write_bytes((tmp_path / "a.stl").read_bytes()[:length])
    with pytest.raises(InputError, match=f"expected {got}.*: export it again"):
        kinmo.load(tmp_path / "a.stl")


@pytest.mark.parametrize("rest", [b"\0", b"\r\n", b"made by a slicer", bytes(50)])
def test_bytes_behind_the_triangles_of_a_binary_stl_change_nothing(rest: bytes, tmp_path: Path) -> None:
    path = tmp_path / "a.stl"
    trimesh.util.concatenate([box((1, 1, 1)), box((1, 1, 1), (3, 0, 0))]).export(path)
    plain = kinmo.load(path)
    path.write_bytes(path.read_bytes() + rest)
    longer = kinmo.load(path)
    for one, other in zip(plain.meshes(), longer.meshes(), strict=True):
        np.testing.assert_array_equal(one.triangles, other.triangles)


def test_labels_count_over_all_solids_in_the_order_of_the_file(tmp_path: Path) -> None:
    facet = "facet normal 0 0 0\nouter loop\nvertex {0} 0 0\nvertex {0} 1 0\nvertex {0} 0 1\nendloop\nendfacet\n"
    solids = "".join(f"solid {name}\n{facet.format(i)}endsolid {name}\n" for i, name in enumerate(["b", "a", "b", ""]))
    (tmp_path / "a.stl").write_text(solids)
    np.save(tmp_path / "faces.npy", [0, 0, 1, 1])
    shape = kinmo.load(tmp_path / "a.stl", labels=tmp_path / "faces.npy")
    assert sorted(sorted(set(mesh.vertices[:, 0].tolist())) for mesh in shape.meshes()) == [[0.0, 1.0], [2.0, 3.0]]
