"""Pliers, tongs and shears: two crossing jaws, or two arms joined at one end."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.posture import lay_down
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import cylinder, extrude, mirror, rounded_path, sweep
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject, hinge


@dataclass(frozen=True)
class _Plan:
    """Sizes of one pair, built closed along z with the jaws to +z and the rivet at the origin, flat across y."""

    jaw: float
    jaw_width: float
    arm: float
    spread: float
    rod: float
    thickness: float


def build(draw: Draw) -> SynthObject:
    """Pliers or tongs whose second half turns about the rivet."""
    plan = _Plan(
        draw.between(0.25, 0.7),
        draw.between(0.07, 0.16),
        draw.between(0.6, 1.2),
        draw.between(0.12, 0.3),
        draw.between(0.03, 0.06),
        draw.between(0.04, 0.1),
    )
    tongs = draw.chance(0.2)
    hooked = draw.chance(0.3)
    root = Node("pliers")
    halves = []
    for side in (1.0, -1.0):
        pieces = _arm(plan) if tongs else _half(plan, side, hooked)
        pieces = pieces if side > 0 else [mirror(piece, 0) for piece in pieces]
        if tongs or draw.chance(0.6):
            halves.append(root.add("leg", *pieces))
        else:
            leg = root.add("leg")
            leg.add("jaw", pieces[0])
            leg.add("handle", *pieces[1:])
            halves.append(leg)
    base = Link("leg", [halves[0]], kind=draw.pick([JointType.FREE, JointType.STATIC]))
    if draw.chance(0.6):
        radius = draw.between(0.03, 0.07)
        base.nodes.append(root.add("screw", cylinder(radius, 1.2 * plan.thickness, "y", (0, 0, 0), 14)))
    opening = draw.between(25.0, 50.0)
    rest = draw.pick([0.0, draw.between(0.0, opening)], [1, 3])
    sense = draw.sign()
    # The jaw of the second half opens towards -x, about -y.
    span = (0.0, opening, rest) if sense < 0 else (-opening, 0.0, -rest)
    motion = hinge((0, draw.between(-0.1, 0.1), 0), (0, sense, 0), span[0], span[1], rest=span[2])
    shape = SynthObject("Pliers", root, [base, Link("leg", [halves[1]], base, motion)])
    lay_down(draw, shape)
    return shape


def _half(plan: _Plan, side: float, hooked: bool) -> list[Mesh]:
    """A jaw in front of the rivet, and the arm behind it on the other side."""
    w, n = plan.jaw_width, plan.jaw
    neck, bite = [[-0.1, -0.5 * w], [0.02, -0.6 * w], [0.08, 0.0]], [[n, 0.0], [n, 0.35 * w], [0.5 * n, 0.8 * w]]
    if hooked:
        bite[1:] = [[0.9 * n, 0.9 * w], [0.5 * n, 1.5 * w]]
    outline = np.array([*neck, *bite, [0.0, w], [-0.1, 0.7 * w]])
    jaw = extrude(outline, 0.5 * plan.thickness, "y", (0, side * 0.25 * plan.thickness, 0))
    corners = [(-0.2 * w, 0, -0.05), (-plan.spread, 0, -0.35 * plan.arm), (-0.8 * plan.spread, 0, -plan.arm)]
    path = rounded_path(np.array(corners), 0.3 * plan.arm, 7)
    shank = sweep(path, plan.rod, 8)
    grip = sweep(path[4:] if len(path) > 6 else path, 1.4 * plan.rod, 8)
    return [jaw, shank, grip]


def _arm(plan: _Plan) -> list[Mesh]:
    """One arm of tongs, joined to the other at the origin."""
    reach = plan.arm + plan.jaw
    path = [(0.02, 0, 0), (0.6 * plan.spread, 0, 0.3 * reach), (0.5 * plan.spread, 0, 0.75 * reach), (0.02, 0, reach)]
    return [sweep(rounded_path(np.array(path), 0.3 * reach, 7), plan.rod, 8)]
