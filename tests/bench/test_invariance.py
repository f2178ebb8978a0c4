"""The bench of changes that must not change a prediction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh

import invariance
from invariance import CHANGES, QUARTER_TURN, MovingBody, is_same, write_changed
from kinmo.core.joint import Joint, JointKind

HINGE = MovingBody(Joint(JointKind.REVOLUTE, np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0]), 0.0, 1.5), 2.0, np.ones(3))


@pytest.mark.parametrize("title", CHANGES)
def test_a_change_keeps_the_geometry(tmp_path, title: str) -> None:
    scene = trimesh.Scene()
    for number, size in enumerate(([1.0, 2.0, 3.0], [0.5, 0.5, 0.2])):
        box = trimesh.creation.box(size, np.eye(4) + 1.5 * number * np.eye(4, k=3))
        scene.add_geometry(box, node_name=f"box {number}")
    source, target = tmp_path / "a.glb", tmp_path / "b.glb"
    scene.export(source)
    write_changed(source, target, CHANGES[title])
    before, after = (trimesh.load_scene(path).to_mesh() for path in (source, target))
    turn = QUARTER_TURN if title == "turned" else np.eye(3)
    rows = [np.unique(np.round(points, 6) + 0.0, axis=0) for points in (before.vertices @ turn.T, after.vertices)]
    assert rows[0].tolist() == rows[1].tolist()
    assert source.read_bytes() != target.read_bytes() or title == "renamed"


def test_a_joint_is_the_same_as_itself_reversed() -> None:
    joint = replace(HINGE.joint, direction=-HINGE.joint.direction)
    assert is_same(HINGE, HINGE._replace(joint=joint), 1.0)


@pytest.mark.parametrize(
    "other",
    [
        HINGE._replace(area=2.1),
        HINGE._replace(middle=np.full(3, 1.01)),
        HINGE._replace(joint=replace(HINGE.joint, pivot=np.array([1.02, 5.0, 0.0]))),
        HINGE._replace(joint=replace(HINGE.joint, kind=JointKind.PRISMATIC)),
        HINGE._replace(joint=replace(HINGE.joint, direction=np.array([0.0, 0.9994, 0.0349]))),
    ],
    ids=["area", "middle", "line", "kind", "direction"],
)
def test_another_joint_is_not_the_same(other: MovingBody) -> None:
    assert not is_same(HINGE, other, 1.0)


def test_a_pivot_may_slide_along_its_axis() -> None:
    assert is_same(HINGE, HINGE._replace(joint=replace(HINGE.joint, pivot=np.array([1.0, 7.0, 0.0]))), 1.0)


def test_files_of_another_format_are_refused(tmp_path) -> None:
    path = tmp_path / "a.glb"
    path.write_bytes(b"glTF" + bytes(40))
    with pytest.raises(SystemExit, match="expected a GLB file"):
        write_changed(path, tmp_path / "b.glb", invariance.renamed)
