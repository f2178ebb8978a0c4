"""True labels of edges from an annotated mobility."""

from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from kinmo.core.edge_labels import EdgeLabels, label_edges, sibling_edges
from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body, Mobility
from kinmo.core.motion_types import MotionType
from kinmo.core.shape import Part, Shape

UP = np.array([0.0, 1.0, 0.0])
NAMES = ("frame", "door", "drawer")


def cabinet(order: tuple[int, ...]) -> tuple[Shape, Mobility, dict[int, MotionType]]:
    """A frame, a door (a node with the leaves surface and knob) and a drawer, in the given order below the root."""
    parts = [Part(100, "cabinet", None)]
    index: dict[str, int] = {}
    children: list[int] = []
    for number in order:
        name = NAMES[number]
        node = len(parts)
        children.append(node)
        index[name] = node
        if name == "door":
            parts.append(Part(number, name, 0, (node + 1, node + 2)))
            index["surface"], index["knob"] = node + 1, node + 2
            parts += [Part(10, "surface", node), Part(11, "knob", node)]
        else:
            parts.append(Part(number, name, 0))
    parts[0] = Part(100, "cabinet", None, tuple(children))
    hinge = Joint(JointKind.REVOLUTE, UP, np.array([0.3, 0.0, 0.0]), 0.0, 1.5)
    twist = Joint(JointKind.REVOLUTE, np.array([0.0, 0.0, 1.0]), np.zeros(3))
    slide = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3), 0.0, 0.4)
    bodies = (
        Body(0, "frame", (index["frame"],)),
        Body(1, "door", (index["surface"],), 0, hinge),
        Body(2, "knob", (index["knob"],), 1, twist),
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


def test_only_motion_edges_have_a_joint() -> None:
    shape, mobility, types = cabinet((0, 1, 2))
    labels = label_edges(shape, mobility, sibling_edges(shape), types)
    moving = labels.types < MotionType.FIXED
    assert (labels.bodies[moving] >= 0).all()
    assert not labels.directions[~moving].any()
    np.testing.assert_allclose(np.linalg.norm(labels.directions[moving], axis=1), 1.0)


def test_parts_of_one_body_have_a_fixed_edge() -> None:
    shape, mobility, types = cabinet((0, 1, 2))
    door = next(b for b in mobility.bodies if b.name == "door")
    knob = next(b for b in mobility.bodies if b.name == "knob")
    rigid = Mobility((mobility.bodies[0], Body(1, "door", door.leaves + knob.leaves, 0, door.joint), mobility.bodies[3]))
    edges = sibling_edges(shape)
    found = by_name(shape, label_edges(shape, rigid, edges, types), edges)
    assert found["knob", "surface"] is found["surface", "knob"] is MotionType.FIXED
