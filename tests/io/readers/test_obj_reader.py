"""The reader of OBJ files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from kinmo.core.errors import InputError
from kinmo.io.readers.obj_reader import parse_obj
from kinmo.io.readers.polygons import triangulate

WHERE = Path("some.obj")
coordinates = st.floats(-1e6, 1e6, allow_nan=False)


def parse(text: str):
    return parse_obj(text.encode(), WHERE)


@st.composite
def polygon_meshes(draw):
    vertices = draw(st.lists(st.tuples(*[coordinates] * 3), min_size=4, max_size=12))
    corner = st.integers(0, len(vertices) - 1)
    faces = draw(st.lists(st.lists(corner, min_size=3, max_size=6), min_size=1, max_size=8))
    return vertices, faces


@given(polygon_meshes(), st.booleans(), st.sampled_from(["{0}", "{0}/1", "{0}//1", "{0}/1/1"]), st.sampled_from(["\n", "\r\n"]))
def test_polygons_become_triangles_in_all_notations(mesh, negative, corner, newline):
    vertices, faces = mesh
    lines = ["o thing", *(f"v {x!r} {y!r} {z!r}" for x, y, z in vertices), "vt 0 0", "vn 0 0 1", "g group"]
    shift = len(vertices) if negative else -1
    lines += ["f " + " ".join(corner.format(index - shift) for index in face) for face in faces]
    found = parse(newline.join(lines) + newline)
    sizes = [len(face) for face in faces]
    corners = np.concatenate(faces)
    expected, _ = triangulate(np.array(vertices), corners, np.array(sizes), WHERE)
    np.testing.assert_array_equal(found.vertices[found.faces], np.array(vertices)[expected])


def test_negative_indices_count_back_from_their_own_line():
    first = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n"
    second = "v 0 0 1\nv 1 0 1\nv 0 1 1\nf -3 -2 -1\nf 1 2 -1\n"
    found = parse(first + second)
    assert found.vertices[found.faces][:, :, 2].tolist() == [[0, 0, 0], [1, 1, 1], [0, 0, 1]]


def test_colours_weights_comments_and_broken_lines_are_ignored():
    plain = parse("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    dressed = parse("  v 0 0 0 1.0 0.5 0.5 # red\nv\t1 0 0\nv 0 \\\n1 0\nl 1 2\np 1\nf 1 2 \\\n3 # front\nvp 0 0\nvn 1 0 0\n")
    np.testing.assert_array_equal(plain.vertices[plain.faces], dressed.vertices[dressed.faces])


def test_a_byte_order_mark_is_ignored():
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    plain, marked = parse(text), parse(f"\ufeff{text}")
    np.testing.assert_array_equal(plain.vertices[plain.faces], marked.vertices[marked.faces])


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
def test_utf_16_with_its_mark_is_read(encoding):
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    found = parse_obj(f"\ufeff{text}".encode(encoding), WHERE)
    np.testing.assert_array_equal(found.vertices, parse(text).vertices)


def test_a_word_among_the_corners_of_a_face_is_quoted():
    with pytest.raises(InputError, match=r"^some.obj: expected numbers \(found a\)$"):
        parse("v 0 0 0\nf a b c\n")


def test_unused_vertices_are_dropped_even_if_they_are_not_finite():
    found = parse("v nan 0 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 2 3 4\n")
    assert len(found.vertices) == 3


@pytest.mark.parametrize("text", ["", "v 0 0 0\n", "v 0 0 0\nv 1 0 0\nl 1 2\n", "v 0 0 0\nv 1 0 0\nf 1 2\n"])
def test_a_file_without_faces_has_no_mesh(text):
    assert parse(text) is None


@pytest.mark.parametrize(
    "text",
    [
        "f 1 2 3\n",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 1 2\n",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 x\n",
        "v 0 0 0\nv 1 0\nv 0 1 0\nf 1 2 3\n",
        "v 0 0 0\nv 1 zero 0\nv 0 1 0\nf 1 2 3\n",
        "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n",
        "v 0 0 0\nv inf 0 0\nv 0 1 0\nf 1 2 3\n",
        "v 0 0 0\nv 1e300 0 0\nv 0 1 0\nf 1 2 3\n",
        "v 0 0 0\nv 2e12 0 0\nv 0 1 0\nf 1 2 3\n",
        "v 0 0 0\nv\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "v 0 0 0\nv # empty\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nv",
    ],
)
def test_a_wrong_file_is_an_error_with_its_name(text):
    with pytest.raises(InputError, match=r"some\.obj"):
        parse(text)


@given(st.binary(max_size=200), st.binary(max_size=20))
def test_any_bytes_give_a_mesh_nothing_or_an_input_error(data, tail):
    for text in (data, b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n" + data, b"v 0 0 0\nf 1 1 1\nf " + tail):
        try:
            found = parse_obj(text, WHERE)
        except InputError:
            continue
        assert found is None or found.faces.max() < len(found.vertices)


@pytest.mark.real
def test_real_files_give_the_same_surface_as_with_trimesh(real_objects):
    for folder in real_objects[::20]:
        for path in sorted((folder / "textured_objs").glob("*.obj"))[:5]:
            ours = parse_obj(path.read_bytes(), path)
            theirs = trimesh.load(path, force="mesh", process=False, skip_materials=True)
            if ours is None:
                continue
            assert len(ours.faces) == len(theirs.faces)
            np.testing.assert_allclose(trimesh.Trimesh(ours.vertices, ours.faces, process=False).area, theirs.area, rtol=1e-9)
