"""overrides.toml: its content is checked, and every mistake is one line with file and field."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinmo.core.errors import InputError
from kinmo.io.readers.overrides_reader import parse_overrides, read_overrides
from kinmo.io.writers.overrides_writer import overrides_text

WHOLE = """
[bodies.door_left]
name = "left_door"
type = "hinge"
axis = [0, 2, 0]
origin = [-0.3, 0.4, 0.25]
range = [0, 110]
parent = "base"
parts = ["door", 7]
flip = true

[bodies.3]
alternative = 2
parent = 0
range = "unlimited"

[new_bodies.drawer]
parts = ["front", "box"]
type = "slider"
axis = [0, 0, 1]
range = [0, 0.3]
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "overrides.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_every_field_is_read(tmp_path: Path) -> None:
    overrides = read_overrides(written(tmp_path, WHOLE))
    door, third, drawer = overrides.bodies["door_left"], overrides.bodies["3"], overrides.new_bodies["drawer"]
    assert (door.name, door.type, door.range, door.parent, door.flip) == ("left_door", "hinge", (0.0, 110.0), "base", True)
    assert door.axis == pytest.approx([0, 1, 0]) and door.origin == pytest.approx([-0.3, 0.4, 0.25])
    assert door.parts == ("door", 7)
    assert (third.alternative, third.parent, third.range, third.parts, third.axis) == (2, 0, "unlimited", None, None)
    assert (drawer.parts, drawer.type, drawer.range) == (("front", "box"), "slider", (0.0, 0.3))


def test_an_empty_file_has_no_corrections(tmp_path: Path) -> None:
    overrides = read_overrides(written(tmp_path, "# checked\n"))
    assert not overrides.bodies and not overrides.new_bodies and overrides.table == {}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[bodies", r"overrides\.toml: expected TOML \("),
        ("[body.door]", r"overrides\.toml: body: unknown key \(did you mean bodies\?\)"),
        ("[door]", r"door: unknown key: for a body of this name write \[bodies\.door\]"),
        ("bodies = 3", r"bodies: expected tables \[bodies\.NAME\]"),
        ("[bodies]\ndoor = 3", r"bodies\.door: expected a table \[bodies\.door\]"),
        (
            "[bodies.door]\nrnage = [0, 1]",
            r"bodies\.door\.rnage: unknown key \(did you mean range\?\); expected one of name, type",
        ),
        ("[bodies.door]\ntype = 'hing'", r"bodies\.door\.type: .*got hing \(did you mean hinge\?\)"),
        ("[bodies.door]\ntype = 'revolute'", r"bodies\.door\.type: .*got revolute \(did you mean hinge\?\)"),
        ("[bodies.door.001]\nflip = true", r'bodies\.door\.001: unknown key: .*write \[bodies\."door\.001"\]'),
        ("[bodies.door]\ntype = 3", r"bodies\.door\.type: expected a text"),
        ("[bodies.door]\nname = ' '", r"bodies\.door\.name: expected a name"),
        ("[bodies.door]\naxis = [0, 0, 0]", r"bodies\.door\.axis: expected a direction, found zero"),
        ("[bodies.door]\naxis = [0, 1]", r"bodies\.door\.axis: expected three numbers, such as \[0, 1, 0\]"),
        ("[bodies.door]\naxis = 'y'", r"bodies\.door\.axis: expected three numbers"),
        ("[bodies.door]\norigin = 0.4", r"bodies\.door\.origin: expected three numbers"),
        ("[bodies.door]\norigin = [0, nan, 0]", r"bodies\.door\.origin\[1\]: expected a finite number"),
        ("[bodies.door]\nrange = [10, 90]", r"bodies\.door\.range: expected a range that contains 0"),
        ("[bodies.door]\nrange = [-90, -10]", r"bodies\.door\.range: expected a range that contains 0"),
        ("[bodies.door]\nrange = [90, 0]", r"bodies\.door\.range: expected the smaller value first: \[0, 90\]"),
        ("[bodies.door]\nrange = [0, 0]", r"bodies\.door\.range: .*write type = \"fixed\""),
        ("[bodies.door]\nrange = 'free'", r"bodies\.door\.range: expected two numbers, such as \[0, 90\], or \"unlimited\""),
        ("[bodies.door]\nrange = [0, 1, 2]", r"bodies\.door\.range: expected two numbers"),
        ("[bodies.door]\nrange = 110", r"bodies\.door\.range: expected two numbers"),
        ("[bodies.door]\nparent = 1.5", r"bodies\.door\.parent: expected the name or the number of a body"),
        ("[bodies.door]\nparts = 'door'", r"bodies\.door\.parts: expected a list of all parts, by name or by number"),
        ("[bodies.door]\nparts = [true]", r"bodies\.door\.parts\[0\]: expected the name or the number of a part"),
        ("[bodies.door]\nalternative = 0", r"bodies\.door\.alternative: expected the rank"),
        ("[bodies.door]\nflip = 1", r"bodies\.door\.flip: expected true or false"),
        ("[bodies.door]\nname = 2020-01-01", r"bodies\.door\.name: expected a text"),
        ("[new_bodies.lid]\ntype = 'hinge'", r"new_bodies\.lid\.parts: needed for a new body"),
        ("[new_bodies.lid]\ntype = 'hinge'\nparts = []", r"new_bodies\.lid\.parts: needed for a new body"),
        ("[new_bodies.lid]\nparts = ['a']", r"new_bodies\.lid\.type: needed for a new body"),
        ("[new_bodies.lid]\nalternative = 2", r"new_bodies\.lid\.alternative: unknown key"),
    ],
)
def test_a_mistake_is_one_line_with_file_and_field(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        read_overrides(written(tmp_path, text))
    assert str(caught.value).startswith(f"{tmp_path / 'overrides.toml'}: ") and "\n" not in str(caught.value)


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"overrides\.toml: missing"):
        read_overrides(tmp_path / "overrides.toml")
    (tmp_path / "overrides.toml").write_bytes(b"\xff")
    with pytest.raises(InputError, match=r"overrides\.toml: expected TOML"):
        read_overrides(tmp_path / "overrides.toml")


def test_a_link_to_a_file_elsewhere_is_followed(tmp_path: Path) -> None:
    (tmp_path / "versioned").mkdir()
    (tmp_path / "result").mkdir()
    written(tmp_path / "versioned", WHOLE)
    (tmp_path / "result" / "overrides.toml").symlink_to(tmp_path / "versioned" / "overrides.toml")
    assert read_overrides(tmp_path / "result" / "overrides.toml").bodies.keys() == {"door_left", "3"}


def test_python_values_count_as_those_of_a_file() -> None:
    table = {"bodies": {3: {"axis": np.array([0, 1, 0]), "range": (0, np.float64(90.0))}}}
    overrides = parse_overrides(table, Path("overrides"))
    assert overrides.bodies["3"].range == (0.0, 90.0)
    assert overrides.table == {"bodies": {"3": {"axis": [0, 1, 0], "range": [0, 90.0]}}}
    assert parse_overrides({"bodies": {"3": {"name": None, "flip": True}}}, Path("o")).table == {
        "bodies": {"3": {"flip": True}}
    }


names = st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=8)
numbers = st.floats(-5.0, 5.0)
values: dict[str, st.SearchStrategy[Any]] = {
    "name": st.just("new"),
    "type": st.sampled_from(["hinge", "slider", "screw", "fixed"]),
    "axis": st.tuples(numbers, numbers, st.just(1.0)).map(list),
    "range": st.one_of(st.just("unlimited"), st.tuples(st.floats(-9, 0), st.floats(0.1, 9)).map(list)),
    "parts": st.lists(st.one_of(names, st.integers(0, 99)), max_size=3),
    "flip": st.booleans(),
}


@settings(max_examples=60)
@given(st.dictionaries(names, st.fixed_dictionaries({}, optional=values), max_size=3))
def test_what_is_written_is_read_back(tmp_path_factory: pytest.TempPathFactory, bodies: dict[str, Any]) -> None:
    overrides = parse_overrides({"bodies": bodies}, Path("o"))
    path = written(tmp_path_factory.mktemp("o"), overrides_text(overrides.table))
    assert read_overrides(path).table == overrides.table
