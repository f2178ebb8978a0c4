"""Joints of a prediction as lines of text for people."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from kinmo.core.joint import KIND_WORDS, Joint, JointKind, joint_from_data
from kinmo.core.references import body_labels
from kinmo.core.shape_estimate import OVERRIDE
from kinmo.core.wording import clean_text

UNCERTAIN = 0.5  # score below which a joint is called uncertain


def joint_lines(document: Mapping[str, Any]) -> list[str]:
    """One line for each joint of joints.json. A body whose name is not unique gets its number, by which overrides name it.

    A line also has the name of the link in exports if it differs from that. Lengths are in metres, and in the units of the
    shape's file if it has others: overrides are in those.

    Raises KeyError, TypeError, IndexError or ValueError if the document has another form.
    """
    bodies, metres_per_unit = document["bodies"], document["shape"]["metres_per_unit"]
    labels = body_labels({body["id"]: body["name"] for body in bodies})
    return [
        _joint_line(_with_link(labels[body["id"]], body), joint_from_data(body["joint"]), body["estimates"][0], metres_per_unit)
        for body in bodies
        if body["joint"] is not None
    ]


def _with_link(label: str, body: Mapping[str, Any]) -> str:
    """The label of a body with the name of its link, if that differs and joints.json has it."""
    link = body.get("link", label)
    return label if link == label else f"{label} (link {clean_text(link)})"


def _joint_line(label: str, joint: Joint, estimate: Mapping[str, Any], metres_per_unit: float) -> str:
    if joint.lower is None or joint.upper is None:
        extent = "without limits"
    elif joint.kind is JointKind.REVOLUTE:
        extent = f"{np.degrees(joint.lower):.0f} to {np.degrees(joint.upper):.0f}°"
    else:
        extent = f"{metres_per_unit * joint.lower:.3g} to {metres_per_unit * joint.upper:.3g} m"
        if metres_per_unit != 1.0:
            extent = f"{joint.lower:.3g} to {joint.upper:.3g} units ({extent})"
    score = estimate["score"]
    doubt = "" if score >= UNCERTAIN else ", uncertain"
    certainty = "corrected by hand" if estimate["source"] == OVERRIDE else f"score {score:.2f}{doubt}"
    return f"  {label}: {KIND_WORDS[joint.kind]}, {extent}, {certainty}"
