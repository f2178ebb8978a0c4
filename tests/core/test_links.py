"""Robot links from bodies."""

from __future__ import annotations

import numpy as np

from kinmo.core.joint import Joint, JointKind
from kinmo.core.links import links_of
from kinmo.core.mobility import Body, Mobility

SLIDER = Joint(JointKind.PRISMATIC, np.array([0.0, 0, 1]), np.zeros(3))


def test_several_roots_form_one_base() -> None:
    links = links_of(Mobility((Body(0, "a", (1,)), Body(1, "b", (2,)), Body(2, "c", (3,), 1, SLIDER))))
    assert [(link.bodies, link.parent) for link in links] == [((0, 1), None), ((2,), 0)]


def test_bodies_that_are_fixed_to_each_other_form_one_link() -> None:
    bodies = (
        Body(0, "knob", (1,), 1),
        Body(1, "door", (2,), 2, SLIDER),
        Body(2, "frame", (3,)),
        Body(3, "lock", (4,), 0, SLIDER),
    )
    links = links_of(Mobility(bodies))
    assert [(link.name, link.body, link.leaves, link.parent) for link in links] == [
        ("base", None, (3,), None),
        ("door", 1, (1, 2), 0),
        ("lock", 3, (4,), 1),
    ]


def test_without_a_root_body_the_base_is_empty() -> None:
    (base,) = links_of(Mobility(()))
    assert (base.bodies, base.leaves) == ((), ())
