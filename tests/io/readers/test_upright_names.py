"""Names of high and low parts tell the up direction."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from kinmo.core.shape import Mesh
from kinmo.io.readers import READERS
from kinmo.io.readers.upright_names import up_by_names

CARCASS = {
    "carcass_top": ((0.0, 0.0, 0.95), (0.8, 0.3, 1.0)),
    "carcass_bottom": ((0.0, 0.0, 0.0), (0.8, 0.3, 0.05)),
    "door": ((0.0, 0.0, 0.05), (0.8, 0.02, 0.95)),
}


def box(low, high) -> Mesh:
    made = trimesh.creation.box(bounds=[low, high])
    return Mesh(np.array(made.vertices), np.array(made.faces))


def up_of(boxes) -> str | None:
    return up_by_names((name, box(*corners)) for name, corners in boxes.items())


def test_the_top_is_above_the_bottom() -> None:
    assert up_of(CARCASS) == "z"
    lying = {name: tuple((x, z, -y) for x, y, z in corners) for name, corners in CARCASS.items()}
    assert up_of({name: tuple(map(tuple, np.sort(corners, axis=0))) for name, corners in lying.items()}) == "y"


def test_low_parts_alone_are_enough() -> None:
    assert up_of({"board": ((0, 0, 0.7), (1, 1, 0.75)), "foot": ((0.4, 0.4, 0.0), (0.6, 0.6, 0.05))}) == "z"


@pytest.mark.parametrize(
    "names", [("door", "side", "knob"), ("top", "top left", "knob"), ("top bottom", "a", "b")], ids=["other", "level", "both"]
)
def test_other_names_tell_nothing(names: tuple[str, ...]) -> None:
    places = [((0, 0, 0), (1, 1, 1)), ((1, 0, 0), (2, 1, 1)), ((2, 0, 0), (3, 1, 1))]
    assert up_of(dict(zip(names, places, strict=True))) is None


def test_a_file_without_an_up_direction_gets_that_of_its_names(tmp_path) -> None:
    lines, count = [], 0
    for name, corners in CARCASS.items():
        mesh = box(*corners)
        lines += [f"o {name}", *(f"v {x} {y} {z}" for x, y, z in mesh.vertices)]
        lines += ["f " + " ".join(str(index + count + 1) for index in face) for face in mesh.faces]
        count += len(mesh.vertices)
    path = tmp_path / "cabinet.obj"
    path.write_text("\n".join(lines), encoding="utf-8")
    shape = READERS["obj"].read(path)
    assert shape.up == (0.0, 0.0, 1.0)
    assert shape.guesses["up"] == "up +z (names of parts)"
    path.write_text("\n".join(lines).replace("carcass", "part").replace("_top", "").replace("_bottom", ""), encoding="utf-8")
    assert READERS["obj"].read(path).up == (0.0, 1.0, 0.0)
