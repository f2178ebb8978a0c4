"""Scenes of glTF files: meshes that show nothing are reported."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from gltf_files import cabinet

import kinmo


@pytest.mark.parametrize("fields", [{}, {"primitives": []}])
def test_meshes_without_primitives_are_named(fields: dict[str, Any], tmp_path: Path) -> None:
    made = cabinet()
    made.document["meshes"] += [{"name": "drawer", **fields}, fields]
    roots = made.document["scenes"][0]["nodes"]
    roots += [made.node("drawer", mesh=3), made.node("second", mesh=3), made.node("shelf", mesh=4)]
    shape = kinmo.load(made.write_glb(tmp_path / "a.glb"))
    assert shape.repairs == (
        "mesh 4, which has no triangles, ignored: 1",
        "mesh drawer, which has no triangles, ignored: 1",
    )


def test_many_meshes_without_primitives_are_counted(tmp_path: Path) -> None:
    made = cabinet()
    made.document["meshes"] += [{} for _ in range(9)]
    made.document["scenes"][0]["nodes"] += [made.node(mesh=3 + number) for number in range(9)]
    shape = kinmo.load(made.write_glb(tmp_path / "a.glb"))
    assert len(shape.repairs) == 6
    assert "further meshes without triangles ignored: 4" in shape.repairs
