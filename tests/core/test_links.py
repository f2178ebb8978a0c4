"""Robot links from bodies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinmo.core.joint import Joint, JointKind
from kinmo.core.links import links_of
from kinmo.core.mobility import Body, Mobility
from kinmo.core.references import body_labels

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


def test_links_are_named_after_their_bodies_or_the_number_that_people_see() -> None:
    names = ["Korpus", "Tür links", "引き出し箱", "", "", "Tur/links", "base"]
    bodies = tuple(Body(10 + i, name, (i,), 0 if i else None, SLIDER if i else None) for i, name in enumerate(names))
    links = links_of(Mobility(bodies))
    assert [link.name for link in links] == ["base", "Tur_links", "body_12", "body_13", "body_14", "Tur_links_2", "base_2"]
    assert [link.joint_name for link in links] == ["", *(f"{link.name}_joint" for link in links[1:])]
    labels = body_labels({body.id: body.name for body in bodies})
    assert [labels[13], labels[14]] == ["#13", "#14"]


def test_only_screws_have_a_second_link_and_joint() -> None:
    screw = replace(SLIDER, kind=JointKind.SCREW)
    _, cap, drawer = links_of(Mobility((Body(0, "a", ()), Body(1, "cap", (), 0, screw), Body(2, "cap_slide", (), 0, SLIDER))))
    assert (cap.name, cap.joint_name) == ("cap", "cap_joint")
    assert (cap.slide_link, cap.slide_joint_name) == ("cap_slide_2", "cap_slide_joint_2")
    assert (drawer.name, drawer.joint_name) == ("cap_slide", "cap_slide_joint")
    assert (drawer.slide_link, drawer.slide_joint_name) == ("", "")


def test_without_a_root_body_the_base_is_empty() -> None:
    (base,) = links_of(Mobility(()))
    assert (base.bodies, base.leaves) == ((), ())
