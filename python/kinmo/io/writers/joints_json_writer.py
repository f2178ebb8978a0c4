"""joints.json: everything that kinmo says of a shape, for programs (docs/joints-json.md, joints.schema.json).

In the frame and the lengths of the shape's file, angles in radians.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from kinmo._core import __version__
from kinmo.core.joint import CoarseType, Joint, JointKind, MotionType
from kinmo.core.mobility import Body, Mobility, has_cycle
from kinmo.core.prediction import JointEstimate, Prediction
from kinmo.core.shape import Shape
from kinmo.io.atomic_files import write_text_atomically
from kinmo.io.readers.field import Field
from kinmo.io.readers.sources import shown
from kinmo.io.readers.untrusted_files import read_json

SCHEMA_VERSION = 1


@dataclass(frozen=True)
class Provenance:
    """What a prediction was made with. `weights` is a hash of the models, None for a method without any."""

    weights: str | None = None
    config: Mapping[str, Any] = field(default_factory=dict)


def schema() -> dict[str, Any]:
    """The JSON Schema of the file."""
    text = files("kinmo.io.writers").joinpath("joints.schema.json").read_text(encoding="utf-8")
    document: dict[str, Any] = json.loads(text)
    return document


def joints_document(shape: Shape, prediction: Prediction, provenance: Provenance) -> dict[str, Any]:
    """The content of joints.json."""
    return {
        "schema_version": SCHEMA_VERSION,
        "kinmo": __version__,
        "method": prediction.method,
        "weights": provenance.weights,
        "config": dict(provenance.config),
        "shape": {
            "id": shape.id,
            "category": prediction.category,
            "layout": shape.layout,
            "source": shown(shape.source.absolute()),
            "up": [float(value) for value in shape.up],
            "center": shape.center.tolist(),
            "diagonal": shape.diagonal,
            "repairs": list(shape.repairs),
        },
        "bodies": [_body(shape, prediction, index) for index in range(len(prediction.mobility.bodies))],
    }


def write_joints_json(path: Path, shape: Shape, prediction: Prediction, provenance: Provenance) -> Path:
    """Write joints.json at `path`, as a whole or not at all; returns `path`."""
    text = json.dumps(joints_document(shape, prediction, provenance), indent=1, ensure_ascii=False, allow_nan=False)
    write_text_atomically(path, text + "\n")
    return path


def _body(shape: Shape, prediction: Prediction, index: int) -> dict[str, Any]:
    body = prediction.mobility.bodies[index]
    leaves = [shape.parts[leaf] for leaf in body.leaves]
    return {
        "id": body.id,
        "name": body.name,
        "parent": body.parent,
        "parts": [{"id": part.id, "name": part.name} for part in leaves],
        "is_junk": bool(body.leaves) and prediction.mobility.junk >= set(body.leaves),
        "joint": None if body.joint is None else _joint(body.joint),
        "estimates": [_estimate(estimate) for estimate in prediction.estimates[index]],
        "network": _estimate(prediction.network_estimates[index]),
    }


def _estimate(estimate: JointEstimate) -> dict[str, Any]:
    return {
        "type": estimate.type.name,
        "classes": len(type(estimate.type)),
        "score": float(estimate.score),
        "terms": {name: float(value) for name, value in estimate.terms.items()},
        "source": estimate.source,
        "joint": None if estimate.joint is None else _joint(estimate.joint),
    }


def _joint(joint: Joint) -> dict[str, Any]:
    return {
        "kind": joint.kind.value,
        "direction": np.asarray(joint.direction, float).tolist(),
        "pivot": np.asarray(joint.pivot, float).tolist(),
        "lower": None if joint.lower is None else float(joint.lower),
        "upper": None if joint.upper is None else float(joint.upper),
        "rest": float(joint.rest),
    }


def read_joints_json(path: Path, shape: Shape) -> tuple[Prediction, Provenance]:
    """Read what `write_joints_json` wrote for `shape`.

    Raises InputError for a file of another schema version or shape, and for whatever else it cannot be.
    """
    document = Field(path, read_json(path, path.parent))
    version = document["schema_version"]
    if version.integer() != SCHEMA_VERSION:
        raise version.fail(f"expected {SCHEMA_VERSION}")
    if document["shape"]["id"].text() != shape.id:
        raise document["shape"]["id"].fail(f"expected {shape.id}")
    leaf_of = {shape.parts[leaf].id: leaf for leaf in shape.leaves}
    entries = document["bodies"].items()
    bodies = tuple(_read_body(entry, leaf_of, len(entries)) for entry in entries)
    owned = sorted(leaf for body in bodies for leaf in body.leaves)
    if owned != sorted(shape.leaves):
        raise document["bodies"].fail("expected every leaf of the shape in one body")
    if has_cycle([body.parent for body in bodies]):
        raise document["bodies"].fail("expected a tree of bodies, found a cycle")
    junk_leaves = (body.leaves for body, entry in zip(bodies, entries, strict=True) if entry["is_junk"].flag())
    junk = frozenset(leaf for leaves in junk_leaves for leaf in leaves)
    config = document["config"].value
    if not isinstance(config, dict):
        raise document["config"].fail("expected an object")
    prediction = Prediction(
        shape.id,
        document["shape"]["category"].text(),
        Mobility(bodies, junk),
        tuple(tuple(_read_estimate(item) for item in entry["estimates"].items()) for entry in entries),
        tuple(_read_estimate(entry["network"]) for entry in entries),
        document["method"].text(),
    )
    weights = document["weights"]
    return prediction, Provenance(None if weights.is_absent else weights.text(), config)


def _read_body(entry: Field, leaf_of: Mapping[int, int], count: int) -> Body:
    leaves = []
    for part in entry["parts"].items():
        identity = part["id"].integer()
        if identity not in leaf_of:
            raise part["id"].fail(f"the shape has no leaf {identity}")
        leaves.append(leaf_of[identity])
    parent = None if entry["parent"].is_absent else entry["parent"].integer()
    if parent is not None and not 0 <= parent < count:
        raise entry["parent"].fail("expected the index of a body")
    joint = None if entry["joint"].is_absent else _read_joint(entry["joint"])
    return Body(entry["id"].integer(), entry["name"].text(), tuple(leaves), parent, joint)


def _read_estimate(entry: Field) -> JointEstimate:
    joint = None if entry["joint"].is_absent else _read_joint(entry["joint"])
    terms = entry["terms"].value
    if not isinstance(terms, dict):
        raise entry["terms"].fail("expected an object")
    scores = {term: entry["terms"][term].number() for term in terms}
    return JointEstimate(joint, _read_type(entry), entry["score"].number(), scores, entry["source"].text())


def _read_type(entry: Field) -> MotionType | CoarseType:
    count, name = entry["classes"].integer(), entry["type"].text()
    types: dict[int, type[MotionType] | type[CoarseType]] = {len(MotionType): MotionType, len(CoarseType): CoarseType}
    if count not in types:
        raise entry["classes"].fail("expected 5 or 10")
    if name not in types[count].__members__:
        raise entry["type"].fail(f"expected one of {', '.join(types[count].__members__)}")
    return types[count][name]


def _read_joint(entry: Field) -> Joint:
    kind = entry["kind"].text()
    if kind not in {known.value for known in JointKind}:
        raise entry["kind"].fail("expected R, P or PR")
    lower, upper = (None if entry[end].is_absent else entry[end].number() for end in ("lower", "upper"))
    if (lower is None) != (upper is None):
        raise entry["upper" if upper is None else "lower"].fail("expected both ends of a range, or none")
    if lower is not None and upper is not None and lower > upper:
        raise entry["upper"].fail("expected no less than lower")
    direction = entry["direction"].vector()
    if not abs(float(np.linalg.norm(direction)) - 1.0) < 1e-6:
        raise entry["direction"].fail("expected a unit vector")
    return Joint(JointKind(kind), direction, entry["pivot"].vector(), lower, upper, entry["rest"].number(0.0))
