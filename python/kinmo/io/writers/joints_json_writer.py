"""joints.json: the complete prediction for a shape, for programs (docs/reference/joints-json.md, joints.schema.json).

Everything is in the frame and the length unit of the shape's file. Angles are in radians.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from kinmo._core import __version__
from kinmo.core.errors import InputError
from kinmo.core.joint import joint_to_data
from kinmo.core.links import links_of
from kinmo.core.mobility import Mobility
from kinmo.core.shape import Shape
from kinmo.core.shape_digest import shape_digest
from kinmo.core.shape_estimate import JointEstimate, ShapeEstimate
from kinmo.core.wording import printable_path
from kinmo.io.atomic_files import write_json_atomically
from kinmo.io.readers.untrusted_files import plain_path
from kinmo.io.writers.writer import ExportedObject, ExportOptions
from kinmo.robot.physics import DEFAULT_PHYSICS, Physics

FILE_NAME = "joints.json"
SCHEMA_VERSION = 1


def write_joints_json(exported: ExportedObject, folder: Path) -> Path:
    """Write joints.json (see `kinmo.io.writers.writer.Writer`). Raises InputError if `result` is not a prediction."""
    shape, result, options = exported.shape, exported.result, exported.options
    if not isinstance(result, ShapeEstimate):
        raise InputError(folder / FILE_NAME, "holds a prediction with scores: a mobility without scores cannot be written")
    document = joints_document(shape, result, options)
    if exported.notes:
        document["export"]["notes"] = list(exported.notes)
    write_json_atomically(folder / FILE_NAME, document, allow_nan=False)
    return folder / FILE_NAME


def joints_document(shape: Shape, prediction: ShapeEstimate, options: ExportOptions) -> dict[str, Any]:
    """The content of joints.json, as the schema describes it."""
    provenance, correction = options.provenance, prediction.correction
    document = {
        "schema_version": SCHEMA_VERSION,
        "kinmo": __version__,
        "method": prediction.method,
        "weights": provenance.weights,
        "config": dict(provenance.config),
        "shape": {
            "id": shape.id,
            "category": prediction.category,
            "layout": shape.layout,
            "source": printable_path(plain_path(shape.source)),
            "labels": None if shape.labels is None else printable_path(plain_path(shape.labels)),
            "up": [float(value) for value in shape.up],
            "front": None if shape.front is None else [float(value) for value in shape.front],
            "metres_per_unit": float(shape.metres_per_unit),
            "guessed": dict(shape.guesses),
            "center": shape.center.tolist(),
            "diagonal": shape.diagonal,
            "digest": shape_digest(shape),
            "repairs": list(shape.repairs),
        },
        "export": {
            "name": options.name,
            "metres_per_unit": options.metres_per_unit,
            "formats": list(options.formats),
            "collision": options.collision,
            **({"package": options.package} if options.package else {}),
            **({"physics": _physics(options.physics)} if options.physics != DEFAULT_PHYSICS else {}),
        },
        "bodies": _bodies(shape, prediction, _robot_names(prediction.mobility)),
    }
    if correction is not None:
        document["correction"] = {
            "overrides": dict(correction.overrides),
            "notes": list(correction.notes),
            "predicted": _bodies(shape, correction.predicted, {}),
        }
    return document


def _physics(physics: Physics) -> dict[str, Any]:
    return {
        "density": float(physics.density),
        "part_densities": {name: float(density) for name, density in physics.part_densities.items()},
        "damping": None if physics.damping is None else float(physics.damping),
        "friction": None if physics.friction is None else float(physics.friction),
        "effort": float(physics.effort),
        "velocity": float(physics.velocity),
    }


def _robot_names(mobility: Mobility) -> dict[int, dict[str, str | None]]:
    """Names of the link and the joint of each body in exported robots, by index of the body."""
    names: dict[int, dict[str, str | None]] = {}
    for link in links_of(mobility):
        names |= {body: {"link": link.name, "joint_name": None} for body in link.bodies}
        if link.body is not None:
            names[link.body]["joint_name"] = link.joint_name
            if link.slide_link:
                names[link.body] |= {"slide_link": link.slide_link, "slide_joint_name": link.slide_joint_name}
    return names


def _bodies(shape: Shape, prediction: ShapeEstimate, names: Mapping[int, Mapping[str, str | None]]) -> list[dict[str, Any]]:
    return [_body(shape, prediction, index, names.get(index, {})) for index in range(len(prediction.mobility.bodies))]


def _body(shape: Shape, prediction: ShapeEstimate, index: int, names: Mapping[str, str | None]) -> dict[str, Any]:
    body = prediction.mobility.bodies[index]
    return {
        "id": body.id,
        "name": body.name,
        **names,
        "parent": body.parent,
        "parts": [{"id": shape.parts[leaf].id, "name": shape.parts[leaf].name} for leaf in body.leaves],
        "is_junk": prediction.mobility.is_junk(index),
        "joint": None if body.joint is None else joint_to_data(body.joint),
        "estimates": [_estimate(estimate) for estimate in prediction.estimates[index]],
        "network": _estimate(prediction.gnn_estimates[index]) if prediction.gnn_estimates else None,
    }


def _estimate(estimate: JointEstimate) -> dict[str, Any]:
    return {
        "type": estimate.type.name,
        "classes": len(type(estimate.type)),
        "score": float(estimate.score),
        "terms": {name: float(value) for name, value in estimate.terms.items()},
        "source": estimate.source,
        "joint": None if estimate.joint is None else joint_to_data(estimate.joint),
    }
