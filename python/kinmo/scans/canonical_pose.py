"""The state, and the base, that all objects of a category are compared in, whatever their files show."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint, JointKind
from kinmo.core.kinematics import joint_motion, rotation_about
from kinmo.core.mobility import Mobility
from kinmo.core.shape import Mesh
from kinmo.scans.closed_pose import closed, moved_by
from kinmo.scans.folding_joints import folds_of, laid_straight
from kinmo.scans.pseudo_label_closed_pose import likely_closed
from kinmo.scans.visible_base import moved_as_a_whole, with_first_base, with_visible_base

F64 = NDArray[np.float64]
Parts = tuple[Mobility, tuple[Mesh, ...]]

OPENED = 0.5
"""Radians by which hinges are opened to see whereto they open."""


def canonical(mobility: Mobility, meshes: Sequence[Mesh], smallest: float, to_z_up: F64, closes: bool) -> Parts:
    """The object with a base that can be seen (`visible_base`); closed (`closing`), and open to the front, if it `closes`.

    `meshes` are those of the bodies; `smallest` and `to_z_up` are as in `with_visible_base`. `to_z_up` may also take
    left for right, for the base that the object would have in the mirror.
    """
    open_parts, open_meshes, hung_by = with_visible_base(mobility, meshes, smallest, to_z_up)
    if not closes:
        return open_parts, open_meshes
    shut = closed(mobility, meshes, base_is_seen=hung_by is None)
    mobility, meshes, _ = with_visible_base(*shut, smallest, to_z_up)
    # once more: of parts that open the same way the one that is a base now does not close
    return open_to_the_front(*closed(mobility, meshes), to_z_up)


def likely_canonical(mobility: Mobility, meshes: Sequence[Mesh], smallest: float, to_z_up: F64, widest: float) -> Parts:
    """The same of an object whose limits are guesses: closed as is likely (`likely_closed`), hinges opening to `widest`.

    What hangs by something that cannot be seen is closed where it folds together, and lies straight then (`folding`).
    """
    mobility, meshes, hung_by = with_visible_base(mobility, meshes, smallest, to_z_up)
    folds = {} if hung_by is None else folds_of(mobility, meshes, hung_by)
    if hung_by is not None and folds:
        # before it is closed: along an axis it takes up less room closed than open
        mobility, meshes = laid_straight(mobility, meshes, hung_by, folds)
    parts = closed(likely_closed(mobility, meshes, widest, folds), meshes)
    if hung_by is not None:
        parts = with_first_base(*parts, smallest, to_z_up)
    return open_to_the_front(*parts, to_z_up)


def open_to_the_front(mobility: Mobility, meshes: Sequence[Mesh], to_z_up: F64) -> Parts:
    """The closed object, turned half round (about up) if its parts open to the back more than in any other direction.

    The front of a door that is the same from both sides is in its file by chance.
    """
    way = np.zeros(3)
    for index, body in mobility.movable():
        if body.joint is not None:
            way += to_z_up @ _opening(
                body.joint, np.mean([meshes[index].vertices.min(axis=0), meshes[index].vertices.max(axis=0)], axis=0)
            )
    if way[0] <= 0.0 or way[0] < np.abs(way).max():
        return mobility, tuple(meshes)
    return moved_as_a_whole(mobility, meshes, rotation_about(Joint(JointKind.REVOLUTE, to_z_up[2], np.zeros(3)), np.pi))


def _opening(joint: Joint, middle: F64) -> F64:
    """Where to the middle [3] of a closed part goes when it is opened; nowhere if nobody knows, or to either side."""
    if joint.lower is None or joint.upper is None or joint.rest > joint.lower:
        return np.zeros(3)
    value = joint.lower + OPENED if joint.kind is JointKind.REVOLUTE else joint.upper
    return moved_by(joint_motion(joint, min(value, joint.upper)), middle) - middle
