"""Roles of a shape's leaves when one body moves."""

from __future__ import annotations

from dataclasses import replace

from small_shapes import cabinet

from kinmo.methods.paper.leaf_roles import leaf_roles


def test_a_body_moves_its_descendants_along() -> None:
    shape = cabinet(2)
    bodies = shape.mobility.bodies
    knob = replace(bodies[1], id=9, leaves=bodies[1].leaves[1:], parent=1)
    door = replace(bodies[1], leaves=bodies[1].leaves[:1])
    plain, nested = leaf_roles(shape, bodies), leaf_roles(shape, (bodies[0], door, *bodies[2:], knob))
    assert nested[1].moving == plain[1].moving
    assert nested[-1].moving == plain[1].moving[1:]
    assert nested[-1].reference == nested[1].own == plain[1].moving[:1]
    assert nested[1].obstacles == plain[1].obstacles


def test_all_obstacles_are_the_reference_of_a_body_without_a_parent() -> None:
    shape = cabinet(2)
    root = leaf_roles(shape, [replace(body, parent=None) for body in shape.mobility.bodies])[0]
    assert root.reference == root.obstacles == sorted(set(range(len(shape.leaves))) - set(root.own))
