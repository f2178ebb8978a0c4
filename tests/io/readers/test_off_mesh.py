"""Meshes of OFF files."""

from __future__ import annotations

from pathlib import Path

import pytest

from kinmo.core.errors import InputError
from kinmo.io.readers.off_mesh import read_off_mesh

WHERE = Path("some.off")
NOTCHED = "OFF # a quad with a notch, and a triangle\n5 2 0\n0 0 0\n4 0 0\n1 1 0\n0 4 0\n0 0 1\n4 0 1 2 3\n3 0 1 4 255 0 0\n"


@pytest.mark.parametrize("text", [NOTCHED, NOTCHED.replace("OFF # a quad with a notch, and a triangle\n", "COFF ")])
def test_polygons_and_colours_are_read(text):
    mesh = read_off_mesh(text.encode(), WHERE)
    assert len(mesh.faces) == 3
    assert mesh.face_areas.sum() == pytest.approx(4.0 + 2.0)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "expected an OFF file"),
        ("ply", "expected an OFF file"),
        ("OFF\n", "whole OFF file"),
        ("OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", "has no faces"),
        ("OFF\n0 0 0\n", "has no faces"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n", "whole OFF file"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", r"outside 0\.\.2"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 -1 2\n", r"outside 0\.\.2"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4 0 1 2\n", "number of corners"),
        ("OFF\n3 1 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n", "whole OFF file"),
        ("OFF\n3 1 0\n0 0 0\n1 0 inf\n0 1 0\n3 0 1 2\n", "finite coordinates"),
        ("OFF\n99999999999999999999 1 0\n", "whole OFF file"),
    ],
)
def test_a_wrong_file_is_an_error(text, problem):
    with pytest.raises(InputError, match=problem):
        read_off_mesh(text.encode(), WHERE)
