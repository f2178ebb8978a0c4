"""Edge labels from an annotated mobility."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinmo.core.box import Box
from kinmo.core.edge_labels import EdgeLabels, label_edges, motion_type, sibling_edges
from kinmo.core.joint import CoarseType, Joint, JointKind, MotionType
from kinmo.core.mobility import Body, Mobility, descendants, has_cycle
from kinmo.core.shape import Part, Shape

UP = np.array([0.0, 1.0, 0.0])
NAMES = ("frame", "door", "drawer")
PANEL = Box(np.zeros(3), np.eye(3), np.array([0.3, 0.5, 0.02]))


def cabinet(order: tuple[int, ...]) -> tuple[Shape, Mobility, dict[int, MotionType]]:
    """A frame, a door with a knob (a node of two leaves) and a drawer, listed in the given order below the root."""
    parts = [Part(100, "cabinet", None)]
    index: dict[str, int] = {}
    children: list[int] = []
    for which in order:
        name = NAMES[which]
        node = len(parts)
        children.append(node)
        index[name] = node
        if name == "door":
            parts.append(Part(which, name, 0, (node + 1, node + 2)))
            index["surface"], index["knob"] = node + 1, node + 2
            parts += [Part(10, "surface", node), Part(11, "knob", node)]
        else:
            parts.append(Part(which, name, 0))
    parts[0] = Part(100, "cabinet", None, tuple(children))
    hinge = Joint(JointKind.REVOLUTE, UP, np.array([0.3, 0.0, 0.0]), 0.0, 1.5)
    turn = Joint(JointKind.REVOLUTE, np.array([0.0, 0.0, 1.0]), np.zeros(3))
    slide = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3), 0.0, 0.4)
    bodies = (
        Body(0, "frame", (index["frame"],)),
        Body(1, "door", (index["surface"],), 0, hinge),
        Body(2, "knob", (index["knob"],), 1, turn),
        Body(3, "drawer", (index["drawer"],), 0, slide),
    )
    shape = Shape("1", "StorageFurniture", tuple(parts), Path("cabinet"), "test")
    return shape, Mobility(bodies), {1: MotionType.R_V_S, 2: MotionType.R_H_C, 3: MotionType.P_H}


def by_name(shape: Shape, labels: EdgeLabels, edges: np.ndarray) -> dict[tuple[str, str], MotionType]:
    return {
        (shape.parts[i].name, shape.parts[j].name): MotionType(t)
        for (i, j), t in zip(edges.tolist(), labels.types.tolist(), strict=True)
    }


@given(st.permutations(range(3)))
def test_labels_do_not_depend_on_the_order_of_children(order: list[int]) -> None:
    shape, mobility, types = cabinet(tuple(order))
    edges = sibling_edges(shape)
    assert by_name(shape, label_edges(shape, mobility, edges, types), edges) == {
        ("door", "frame"): MotionType.R_V_S,
        ("frame", "door"): MotionType.NONE,
        ("drawer", "frame"): MotionType.P_H,
        ("frame", "drawer"): MotionType.NONE,
        ("door", "drawer"): MotionType.NONE,
        ("drawer", "door"): MotionType.NONE,
        ("knob", "surface"): MotionType.R_H_C,
        ("surface", "knob"): MotionType.NONE,
    }


def test_a_motion_edge_carries_the_joint_and_others_carry_nothing() -> None:
    shape, mobility, types = cabinet((0, 1, 2))
    labels = label_edges(shape, mobility, sibling_edges(shape), types)
    moving = labels.types < MotionType.FIXED
    assert (labels.bodies[moving] >= 0).all()
    assert not labels.directions[~moving].any()
    np.testing.assert_allclose(np.linalg.norm(labels.directions[moving], axis=1), 1.0)


def test_parts_of_one_body_are_fixed_to_each_other() -> None:
    shape, mobility, types = cabinet((0, 1, 2))
    door = next(b for b in mobility.bodies if b.name == "door")
    knob = next(b for b in mobility.bodies if b.name == "knob")
    rigid = Mobility((mobility.bodies[0], Body(1, "door", door.leaves + knob.leaves, 0, door.joint), mobility.bodies[3]))
    edges = sibling_edges(shape)
    found = by_name(shape, label_edges(shape, rigid, edges, types), edges)
    assert found["knob", "surface"] is found["surface", "knob"] is MotionType.FIXED


@pytest.mark.parametrize(
    ("kind", "direction", "pivot", "expected"),
    [
        (JointKind.REVOLUTE, (0, 1, 0), (0.3, 0, 0), "R_V_S"),
        (JointKind.REVOLUTE, (0, 1, 0), (0.01, 0, 0), "R_V_C"),
        (JointKind.REVOLUTE, (1, 0, 0), (0, -0.5, 0), "R_H_S"),
        (JointKind.REVOLUTE, (0, 0, 1), (0, 0, 0), "R_H_C"),
        (JointKind.PRISMATIC, (0, 0, 1), (9, 9, 9), "P_H"),
        (JointKind.PRISMATIC, (0, -1, 0), (0, 0, 0), "P_V"),
        (JointKind.SCREW, (0, 1, 0), (0, 0, 0), "PR_V"),
        (JointKind.SCREW, (1, 0, 0), (0.3, 0, 0), "PR_H"),
    ],
)
def test_fine_types_tell_kind_orientation_and_place(
    kind: JointKind, direction: tuple[float, ...], pivot: tuple[float, ...], expected: str
) -> None:
    joint = Joint(kind, np.array(direction, float), np.array(pivot, float))
    assert motion_type(joint, PANEL, UP) is MotionType[expected]
    assert motion_type(joint.reversed(), PANEL, UP) is MotionType[expected]
    assert MotionType[expected].coarse is CoarseType[kind.value]
    assert MotionType[expected].kind is kind


@given(st.lists(st.one_of(st.none(), st.integers(0, 7)), min_size=8, max_size=8))
def test_a_cycle_is_found_exactly_where_following_parents_comes_back(parents: list[int | None]) -> None:
    def comes_back(start: int) -> bool:
        node: int | None = start
        for _ in range(len(parents) + 1):
            if node is None:
                return False
            node = parents[node]
        return True

    assert has_cycle(parents) == any(comes_back(i) for i in range(len(parents)))
    if not has_cycle(parents):
        for root in (i for i, parent in enumerate(parents) if parent is None):
            assert descendants(parents, root)[0] == root
