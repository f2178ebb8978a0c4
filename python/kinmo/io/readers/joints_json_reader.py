"""joints.json, read back into a prediction (docs/reference/joints-json.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body, Mobility, has_cycle
from kinmo.core.motion_types import CoarseType, MotionType
from kinmo.core.shape import Shape
from kinmo.core.shape_estimate import Correction, JointEstimate, PredictionProvenance, ShapeEstimate
from kinmo.io.readers.json_field import JsonField
from kinmo.io.readers.untrusted_files import read_json
from kinmo.io.writers.joints_json_writer import SCHEMA_VERSION

UNIT_TOLERANCE = 1e-6
"""Largest difference of the length of a unit vector from 1."""


def read_joints_json(path: Path, shape: Shape) -> tuple[ShapeEstimate, PredictionProvenance]:
    """The prediction for a shape from joints.json, and the models and settings that made it.

    Raises InputError if the file belongs to another shape or schema version, or is wrong. The message names the field.
    """
    return prediction_in(read_document(path), shape)


def read_document(path: Path) -> JsonField:
    """The content of joints.json. Raises InputError if it has another schema version."""
    document = read_json(path, path.parent)
    version = document["schema_version"]
    if version.integer() != SCHEMA_VERSION:
        raise version.fail(f"expected {SCHEMA_VERSION}")
    return document


def prediction_in(document: JsonField, shape: Shape) -> tuple[ShapeEstimate, PredictionProvenance]:
    """The prediction that the content of joints.json describes (see `read_joints_json`)."""
    if document["shape"]["id"].text() != shape.id:
        raise document["shape"]["id"].fail(f"expected {shape.id}")
    config = document["config"].value
    if not isinstance(config, dict):
        raise document["config"].fail("expected an object")
    prediction = _estimates(document, document["bodies"], shape)
    if not document["correction"].is_absent:
        prediction = replace(prediction, correction=_correction(document, shape))
    weights = document["weights"]
    return prediction, PredictionProvenance(None if weights.is_absent else weights.text(), config)


def bodies_in(document: JsonField) -> Mobility:
    """The bodies and joints that the content of joints.json describes, without their leaves: no shape is needed."""
    entries = document["bodies"].items()
    if not entries:
        raise document["bodies"].fail("expected at least one body")
    bodies = tuple(
        Body(entry["id"].integer(), entry["name"].text(), (), _parent(entry, len(entries)), _joint_of(entry))
        for entry in entries
    )
    if has_cycle([body.parent for body in bodies]):
        raise document["bodies"].fail("expected a tree of bodies, found a cycle")
    return Mobility(bodies)


def _correction(document: JsonField, shape: Shape) -> Correction:
    entry = document["correction"]
    overrides = entry["overrides"].value
    if not isinstance(overrides, dict):
        raise entry["overrides"].fail("expected an object")
    notes = tuple(note.whole_text() for note in entry["notes"].items())
    return Correction(_estimates(document, entry["predicted"], shape), overrides, notes)


def _estimates(document: JsonField, listed: JsonField, shape: Shape) -> ShapeEstimate:
    """The prediction with the bodies `listed` in joints.json."""
    leaf_of = {shape.parts[leaf].id: leaf for leaf in shape.leaves}
    entries = listed.items()
    bodies = tuple(_body(entry, leaf_of, len(entries)) for entry in entries)
    owned = sorted(leaf for body in bodies for leaf in body.leaves)
    if owned != sorted(shape.leaves):
        raise listed.fail("expected every leaf of the shape in one body")
    if has_cycle([body.parent for body in bodies]):
        raise listed.fail("expected a tree of bodies, found a cycle")
    junk = (leaf for body, entry in zip(bodies, entries, strict=True) if entry["is_junk"].flag() for leaf in body.leaves)
    return ShapeEstimate(
        shape.id,
        document["shape"]["category"].text(),
        Mobility(bodies, frozenset(junk)),
        tuple(tuple(_estimate(item) for item in entry["estimates"].items()) for entry in entries),
        tuple(_estimate(entry["network"]) for entry in entries if not entry["network"].is_absent),
        document["method"].text(),
    )


def _body(entry: JsonField, leaf_of: Mapping[int, int], count: int) -> Body:
    leaves = []
    for part in entry["parts"].items():
        identity = part["id"].integer()
        if identity not in leaf_of:
            raise part["id"].fail(f"the shape has no leaf {identity}")
        leaves.append(leaf_of[identity])
    return Body(entry["id"].integer(), entry["name"].text(), tuple(leaves), _parent(entry, count), _joint_of(entry))


def _parent(entry: JsonField, count: int) -> int | None:
    parent = None if entry["parent"].is_absent else entry["parent"].integer()
    if parent is not None and not 0 <= parent < count:
        raise entry["parent"].fail("expected the index of a body")
    return parent


def _joint_of(entry: JsonField) -> Joint | None:
    return None if entry["joint"].is_absent else _joint(entry["joint"])


def _estimate(entry: JsonField) -> JointEstimate:
    joint = None if entry["joint"].is_absent else _joint(entry["joint"])
    terms = entry["terms"].value
    if not isinstance(terms, dict):
        raise entry["terms"].fail("expected an object")
    scores = {term: entry["terms"][term].number() for term in terms}
    return JointEstimate(joint, _type(entry), entry["score"].number(), scores, entry["source"].text())


def _type(entry: JsonField) -> MotionType | CoarseType:
    count, name = entry["classes"].integer(), entry["type"].text()
    types: dict[int, type[MotionType] | type[CoarseType]] = {len(MotionType): MotionType, len(CoarseType): CoarseType}
    if count not in types:
        raise entry["classes"].fail("expected 5 or 10")
    if name not in types[count].__members__:
        raise entry["type"].fail(f"expected one of {', '.join(types[count].__members__)}")
    return types[count][name]


def _joint(entry: JsonField) -> Joint:
    kind = entry["kind"].text()
    if kind not in {known.value for known in JointKind}:
        raise entry["kind"].fail("expected R, P or PR")
    lower, upper = (None if entry[end].is_absent else entry[end].number() for end in ("lower", "upper"))
    if (lower is None) != (upper is None):
        raise entry["upper" if upper is None else "lower"].fail("expected both ends of a range, or none")
    if lower is not None and upper is not None and lower > upper:
        raise entry["upper"].fail("expected no less than lower")
    direction = entry["direction"].vector()
    if not abs(float(np.linalg.norm(direction)) - 1.0) < UNIT_TOLERANCE:
        raise entry["direction"].fail("expected a unit vector")
    return Joint(JointKind(kind), direction, entry["pivot"].vector(), lower, upper, entry["rest"].number(0.0))
