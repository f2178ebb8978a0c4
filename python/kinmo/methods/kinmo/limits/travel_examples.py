"""Annotated joints with their limits, as the limits network learns from them, and their files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load, save

from kinmo import _core
from kinmo.core.errors import InputError
from kinmo.core.joint import Joint
from kinmo.core.mobility import descendants
from kinmo.features.candidate_features import CandidateFeatures
from kinmo.features.group_geometry import GroupGeometry, group_geometries
from kinmo.features.prepared_shape import PreparedShape
from kinmo.features.shape_geometry import ShapeGeometry
from kinmo.features.travel_features import travel_features
from kinmo.methods.kinmo.ranking.name_words import category_words, group_words, has_names

MAX_WORDS = 32
"""Most words of a body that count."""
NO_WORD = -1
"""Entry of `TravelExamples.words` without a word."""
UNLIMITED = -1.0
"""Entry of `TravelExamples.travel` of a joint without limits."""


@dataclass(frozen=True, eq=False)
class TravelExamples:
    """J joints as the limits network sees them, and their limits.

    Attributes:
        directed ([J, 2, D] float32): Features of both senses (`kinmo.features.travel_features`).
        shared ([J, S] float32): Features of the joint and of its body.
        words ([J, 32] int64): Hashed words of the body's names and of the category, then `NO_WORD`.
        travel ([J, 2] float32): True travel in both senses, in scales of the joint; `UNLIMITED` without limits; 0 if unknown.
    """

    directed: NDArray[np.float32]
    shared: NDArray[np.float32]
    words: NDArray[np.int64]
    travel: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.directed)


def body_inputs(
    shape: PreparedShape,
    geometry: ShapeGeometry,
    features: CandidateFeatures,
    group: GroupGeometry,
    moving: Sequence[int],
    joints: Sequence[Joint],
) -> tuple[TravelExamples, NDArray[np.float64]]:
    """Examples of joints of one body, with unknown travel, and the scales [J] of their travel.

    Args:
        shape: The shape.
        geometry: Geometry of its leaves.
        features: Candidate features, those of the body among them.
        group: The body relative to the other leaves.
        moving: Positions of all leaves that move along.
        joints: At least one joint, in the normalised frame.
    """
    leaves = group.leaves
    found = travel_features(geometry, group, moving, joints)
    whole = features.group_features[features.group_of[leaves]]
    shared = np.column_stack([found.shared, np.tile(whole, (len(joints), 1))]).astype(np.float32)
    named = group_words(shape, leaves) if has_names(shape) else ()
    known = list(dict.fromkeys(named + category_words(shape)))[:MAX_WORDS]
    words = np.full((len(joints), MAX_WORDS), NO_WORD, np.int64)
    words[:, : len(known)] = known
    return TravelExamples(found.directed, shared, words, np.zeros((len(joints), 2), np.float32)), found.scales


def examples_of(shape: PreparedShape, meshes: _core.Meshes) -> TravelExamples | None:
    """The joints of an annotated shape with their limits; None without joints. `meshes` are in the normalised frame."""
    mobility, _ = shape.annotation
    geometry, features = ShapeGeometry.of_prepared(shape, meshes), CandidateFeatures.of(shape.candidate_features)
    parents = [body.parent for body in mobility.bodies]
    found = []
    for index, body in mobility.movable():
        leaves, joint = shape.body_leaves[index], body.joint
        if not leaves or joint is None:
            continue
        moving = sorted(leaf for other in descendants(parents, index) for leaf in shape.body_leaves[other])
        (group,) = group_geometries(geometry, [leaves])
        example, (scale,) = body_inputs(shape, geometry, features, group, moving, [joint])
        example.travel[:] = UNLIMITED
        if joint.lower is not None and joint.upper is not None:
            example.travel[0] = max(joint.upper - joint.rest, 0.0) / scale, max(joint.rest - joint.lower, 0.0) / scale
        found.append(example)
    return joined(found) if found else None


def joined(examples: Sequence[TravelExamples]) -> TravelExamples:
    """Several examples one after the other."""
    return TravelExamples(*(np.concatenate([getattr(one, field.name) for one in examples]) for field in fields(TravelExamples)))


def to_bytes(examples: TravelExamples) -> bytes:
    """Contents of a file of examples."""
    return save({field.name: np.ascontiguousarray(getattr(examples, field.name)) for field in fields(TravelExamples)})


def read_examples(path: Path) -> TravelExamples:
    """Read examples that `to_bytes` wrote.

    Raises:
        InputError: The file is missing or damaged.
    """
    try:
        arrays = load(path.read_bytes())
        return TravelExamples(**{field.name: arrays[field.name] for field in fields(TravelExamples)})
    except (OSError, KeyError, ValueError, SafetensorError) as error:
        raise InputError(path, f"not examples of joint limits ({error}): remove the folder and train again") from None
