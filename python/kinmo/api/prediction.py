"""The predicted joints of a shape: to look at, to move, and to export."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError, did_you_mean
from kinmo.core.joint import Joint
from kinmo.core.kinematics import forward
from kinmo.core.mobility import Mobility
from kinmo.core.names import unique_names
from kinmo.core.prediction import PredictionProvenance, ShapeEstimate
from kinmo.core.shape import Shape
from kinmo.io.writers import ExportOptions, export
from kinmo.io.writers.joints_json_writer import FILE_NAME, write_joints_json


@dataclass(frozen=True, eq=False)
class PredictedJoint:
    """One predicted joint.

    Attributes:
        name: name of the moving body, unique within the prediction: letters, digits, - and _.
        parent: name of the body that it is attached to; None for a free one.
        joint: kind, axis, limits and rest value, in the shape's own frame and units; angles in radians.
        score: score of the joint in [0, 1]; for kinmo's own method a probability.
        alternatives: other joints of the same body, with their scores, best first.
        parts: indices into `Shape.parts` of the leaves that move.
    """

    name: str
    parent: str | None
    joint: Joint
    score: float
    alternatives: tuple[tuple[Joint, float], ...]
    parts: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Prediction:
    """Predicted bodies and joints of a shape.

    Attributes:
        shape: the shape.
        estimate: everything that the method estimated, in the shape's own frame and units.
        provenance: networks and settings of the method.

    Example:
        >>> prediction = kinmo.Predictor("workspace").predict(kinmo.load("cabinet.glb"))
        >>> for joint in prediction.joints:
        ...     print(joint.name, joint.joint.kind.name, round(joint.score, 2))
        >>> poses = prediction.articulate({"door_left": 0.8})
        >>> prediction.export("out/cabinet", formats=["urdf"])
    """

    shape: Shape
    estimate: ShapeEstimate
    provenance: PredictionProvenance

    @property
    def mobility(self) -> Mobility:
        """Bodies and joints, in the shape's own frame and units."""
        return self.estimate.mobility

    @cached_property
    def body_names(self) -> tuple[str, ...]:
        """Unique names of all bodies, in the order of `mobility.bodies`."""
        return tuple(unique_names(body.name for body in self.mobility.bodies))

    @cached_property
    def joints(self) -> tuple[PredictedJoint, ...]:
        """All predicted joints."""
        names = self.body_names
        found = []
        for index, body in self.mobility.movable():
            assert body.joint is not None, "movable bodies have a joint"
            best, *others = self.estimate.estimates[index]
            parent = None if body.parent is None else names[body.parent]
            alternatives = tuple((other.joint, other.score) for other in others if other.joint is not None)
            found.append(PredictedJoint(names[index], parent, body.joint, best.score, alternatives, body.leaves))
        return tuple(found)

    def articulate(self, values: Mapping[str, float]) -> dict[str, NDArray[np.float64]]:
        """Compute the pose of every body for some joint values.

        Args:
            values: joint values by name of the joint: radians for hinges, lengths of the shape for sliders and screws. Joints
                without a value stay as in the file.

        Returns:
            For each body by name the transformation [4, 4] that takes its points from their place in the file to the new one,
            in the shape's own frame.

        Raises:
            InputError: there is no joint of such a name.
        """
        places = {joint.name: self.body_names.index(joint.name) for joint in self.joints}
        for name in values:
            if name not in places:
                problem = f"no joint {name}{did_you_mean(name, places)}; there are {', '.join(places) or 'none'}"
                raise InputError("values", problem)
        poses = forward(self.mobility, {places[name]: float(value) for name, value in values.items()})
        return dict(zip(self.body_names, poses, strict=True))

    def articulated(self, values: Mapping[str, float]) -> Shape:
        """The shape with its bodies moved to some joint values (see `articulate`)."""
        poses = self.articulate(values)
        parts = list(self.shape.parts)
        for name, body in zip(self.body_names, self.mobility.bodies, strict=True):
            for leaf in body.leaves:
                mesh = parts[leaf].mesh
                assert mesh is not None, "leaves carry meshes"
                vertices = mesh.vertices @ poses[name][:3, :3].T + poses[name][:3, 3]
                parts[leaf] = replace(parts[leaf], mesh=replace(mesh, vertices=vertices))
        return replace(self.shape, parts=tuple(parts))

    def export(
        self,
        folder: Path | str,
        formats: Sequence[str] = ("urdf",),
        *,
        name: str | None = None,
        metres_per_unit: float = 1.0,
    ) -> dict[str, Path]:
        """Write the shape with its joints.

        Args:
            folder: the folder to write; it is replaced as a whole.
            formats: names of formats (`kinmo.io.writers.WRITERS`), such as "urdf", "joints_json" or "partnet_mobility".
            name: name of the model; None for the folder's name.
            metres_per_unit: length of a unit of the shape's file in metres.

        Returns:
            Path of the main file of each format.

        Raises:
            InputError: there is no such format.
        """
        folder = Path(folder)
        options = ExportOptions(name or folder.name, metres_per_unit, provenance=self.provenance)
        return export(self.shape, self.estimate, folder, formats, options)

    def save(self, folder: Path | str) -> Path:
        """Write joints.json: all joints with scores and alternatives (docs/reference/joints-json.md).

        Args:
            folder: the folder to write into.

        Returns:
            Path of the file.
        """
        options = ExportOptions(provenance=self.provenance)
        write_joints_json(self.shape, self.estimate, Path(folder), options)
        return Path(folder) / FILE_NAME
