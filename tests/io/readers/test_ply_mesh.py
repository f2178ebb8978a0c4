"""Meshes of PLY files."""

from __future__ import annotations

import struct
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from kinmo.core.errors import InputError
from kinmo.io.readers.ply_mesh import read_ply_mesh

WHERE = Path("some.ply")
POINTS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 1, 2, 3), (0, 1, 4)]


def ply(form: str, *, newline: str = "\n", name: str = "vertex_indices") -> bytes:
    """A quad and a triangle that share an edge, with columns that kinmo does not use."""
    header = [
        "ply", f"format {form} 1.0", "comment by hand", "element camera 1", "property int lens", "element vertex 5",
        "property double x", "property uchar red", "property double y", "property double z", "element face 2",
        "property float weight", f"property list uchar int {name}", "property list uchar float texcoord", "end_header", "",
    ]  # fmt: skip
    head = newline.join(header).encode()
    if form == "ascii":
        rows = [[50], *([x, 7, y, z] for x, y, z in POINTS), *([0.5, len(face), *face, 1, 0.5] for face in FACES)]
        return head + newline.join(" ".join(map(str, row)) for row in rows).encode()
    order = "<" if "little" in form else ">"
    body = struct.pack(f"{order}i", 50)
    body += b"".join(struct.pack(f"{order}dBdd", x, 7, y, z) for x, y, z in POINTS)
    for face in FACES:
        body += struct.pack(f"{order}fB{len(face)}iBf", 0.5, len(face), *face, 1, 0.5)
    return head + body


FORMS = ["ascii", "binary_little_endian", "binary_big_endian"]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
@pytest.mark.parametrize("name", ["vertex_indices", "vertex_index"])
def test_faces_of_any_number_of_corners_are_read_in_all_forms(form, newline, name):
    mesh = read_ply_mesh(ply(form, newline=newline, name=name), WHERE)
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 4]]
    assert mesh.vertices.tolist() == [list(map(float, point)) for point in POINTS]


def test_numbers_behind_the_last_property_of_a_line_are_left_out():
    head, _, body = ply("ascii").partition(b"end_header\n")
    surplus = b"\n".join(line + b" 9 1 1 1" for line in body.splitlines())
    expected = read_ply_mesh(ply("ascii"), WHERE)
    for text in (surplus, body + b"\n1 2 3\n"):
        mesh = read_ply_mesh(head + b"end_header\n" + text, WHERE)
        assert (mesh.faces.tolist(), mesh.vertices.tolist()) == (expected.faces.tolist(), expected.vertices.tolist())


@pytest.mark.parametrize("encoding", ["ascii", "binary"])
def test_files_of_trimesh_are_read(encoding):
    sphere = trimesh.creation.icosphere()
    mesh = read_ply_mesh(trimesh.exchange.ply.export_ply(sphere, encoding=encoding, vertex_normal=True), WHERE)
    np.testing.assert_array_equal(mesh.faces, sphere.faces)
    np.testing.assert_allclose(mesh.vertices, sphere.vertices, atol=1e-6)


def test_a_concave_face_keeps_its_notch():
    corners = [(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)]
    text = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
    text += "element face 1\nproperty list uchar int vertex_index\nend_header\n"
    text += "".join(f"{x} {y} 0\n" for x, y in corners) + "8 0 1 2 3 4 5 6 7\n"
    assert read_ply_mesh(text.encode(), WHERE).face_areas.sum() == pytest.approx(7.0)


def test_faces_of_fewer_than_three_corners_are_said():
    said = []
    text = ply("ascii").replace(b"0.5 3 0 1 4", b"0.5 2 0 1")
    assert len(read_ply_mesh(text, WHERE, said.append).faces) == 2
    assert said == ["faces of fewer than three corners"]


@pytest.mark.parametrize("form", FORMS)
def test_a_file_that_is_cut_off_is_an_error(form):
    whole = ply(form)
    for length in range(0, len(whole) - 4, 7):
        with pytest.raises(InputError, match=r"some\.ply"):
            read_ply_mesh(whole[:length], WHERE)


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        (b"vertex 5", b"vertex 99999999999", "it has no 99999999999 rows"),
        (b"element face 2\n", b"element face -1\n", "it has no -1 rows"),
        (b"property double x", b"property text x", "expected a header of PLY, found property text x"),
        (b"property double x", b"property double w", "vertex: expected x, y and z, found w, red, y, z"),
        (b"vertex_indices", b"corners", "face: expected a list vertex_indices or vertex_index, found .*corners"),
        (b"0 1 2 3", b"0 1 2 9", r"outside 0\.\.4"),
        (b"0 1 2 3", b"0 1 2 nan", r"outside 0\.\.4"),
        (b"0 1 2 3", b"0 1 two 3", "expected numbers below the header"),
        (b"0.5 4", b"0.5 1e300", "expected a whole PLY file"),
        (b"1 7 1 0", b"1 7 1e13 0", "finite coordinates of at most"),
        (b"end_header", b"end", "with a header"),
    ],
)
def test_a_wrong_file_is_an_error(old, new, problem):
    text = ply("ascii")
    assert old in text
    with pytest.raises(InputError, match=problem):
        read_ply_mesh(text.replace(old, new), WHERE)


@given(st.sampled_from(FORMS), st.lists(st.tuples(st.integers(0, 10_000), st.integers(0, 255)), min_size=1, max_size=4))
def test_a_damaged_file_gives_a_mesh_or_an_input_error(form, changes):
    data = bytearray(ply(form))
    for place, value in changes:
        data[place % len(data)] = value
    with suppress(InputError):
        read_ply_mesh(bytes(data), WHERE)
