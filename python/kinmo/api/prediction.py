"""The predicted joints of a shape: to look at, to move, and to export."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo.core.corrected_estimate import corrected_estimate
from kinmo.core.errors import InputError, did_you_mean
from kinmo.core.joint import Joint, JointKind
from kinmo.core.kinematics import forward
from kinmo.core.links import Link, links_of
from kinmo.core.mobility import Mobility
from kinmo.core.shape import Shape
from kinmo.core.shape_estimate import OVERRIDE, PredictionProvenance, ShapeEstimate
from kinmo.core.wording import counted
from kinmo.dataset.cache import Cache
from kinmo.io.atomic_files import write_text_atomically
from kinmo.io.folder_lock import locked
from kinmo.io.readers.overrides_reader import OVERRIDES_FILE, parse_overrides, read_overrides
from kinmo.io.result_folder import options_in, read_result, write_result
from kinmo.io.writers import ExportedObject, ExportOptions
from kinmo.io.writers.joints_json_writer import write_joints_json
from kinmo.io.writers.overrides_writer import overrides_text
from kinmo.robot.collision_geometry import DEFAULT_MODE, CollisionMode
from kinmo.robot.physics import Physics


@dataclass(frozen=True, eq=False)
class PredictedJoint:
    """One predicted joint.

    Attributes:
        name: Name of the link that moves, unique within the prediction: letters, digits and _. Exports have the same names.
        parent: Name of the link that it is attached to.
        joint: Kind, axis, limits and rest value, in the shape's own frame and units; angles in radians.
        score: Score in [0, 1]; for kinmo's own method a probability.
        alternatives: Other joints of the same link with their scores, best first.
        parts: Indices into `Shape.parts` of the leaves that form the link.
        is_corrected: True if a person gave the joint.
    """

    name: str
    parent: str
    joint: Joint
    score: float
    alternatives: tuple[tuple[Joint, float], ...]
    parts: tuple[int, ...]
    is_corrected: bool = False

    @property
    def kind(self) -> JointKind:
        """Kind of the joint: REVOLUTE, PRISMATIC or SCREW."""
        return self.joint.kind


@dataclass(frozen=True, eq=False, repr=False)
class Prediction:
    """Predicted links and joints of a shape.

    Attributes:
        shape: The shape.
        estimate: Everything that the method estimated, in the shape's own frame and units.
        provenance: Networks and settings of the method.

    Example:
        >>> prediction = kinmo.Predictor("workspace").predict(kinmo.load("cabinet.glb"))
        >>> for joint in prediction.joints:
        ...     print(joint.name, joint.kind.name, round(joint.score, 2))
        >>> poses = prediction.articulate({"door_left": 0.8})
        >>> prediction.export("out/cabinet", formats=["urdf"])
    """

    shape: Shape
    estimate: ShapeEstimate
    provenance: PredictionProvenance

    @classmethod
    def load(cls, folder: Path | str, *, source: Path | str | None = None) -> Prediction:
        """Read a prediction that `kinmo predict`, `export` or `save` wrote, and its shape.

        Args:
            folder: The folder with joints.json.
            source: File or folder of the shape. None for the one that joints.json names.

        Returns:
            The prediction as joints.json has it, with its corrections. An overrides.toml that is newer counts only after
            `kinmo export`, or by `with_overrides`.

        Raises:
            InputError: A file is missing or wrong, or the shape has changed since the prediction.

        Example:
            >>> prediction = kinmo.Prediction.load("out/cabinet")
        """
        saved = read_result(Path(folder), None if source is None else Path(source))
        shape = replace(saved.shape, metres_per_unit=saved.options.metres_per_unit)
        return cls(shape, saved.estimate, saved.options.provenance)

    def with_overrides(self, overrides: Path | str | Mapping[str, Any]) -> Prediction:
        """Correct the prediction by hand (docs/guide/correct.md).

        Corrections apply to what was predicted: they replace those of an earlier call.

        Args:
            overrides: Path of an overrides.toml, or its content as nested dictionaries.

        Returns:
            The corrected prediction. Its `estimate.correction.notes` list consequences, such as bodies that lost all parts.

        Raises:
            InputError: The overrides name a body, part or key that does not exist, or contradict each other.

        Example:
            >>> corrected = prediction.with_overrides({"bodies": {"door": {"type": "hinge", "range": [0, 110]}}})
        """
        if isinstance(overrides, Mapping):
            checked = parse_overrides(overrides, Path("overrides"))
        else:
            checked = read_overrides(Path(overrides))
        return replace(self, estimate=corrected_estimate(self.shape, self.estimate, checked))

    def __repr__(self) -> str:
        return f"Prediction({self.shape.id}: {counted(len(self.joints), 'joint')})"

    @property
    def mobility(self) -> Mobility:
        """Bodies and joints, in the shape's own frame and units."""
        return self.estimate.mobility

    @cached_property
    def links(self) -> tuple[Link, ...]:
        """Rigid links with their names in exports: the base first, parents before children. Fixed bodies share one."""
        return links_of(self.mobility)

    @cached_property
    def joints(self) -> tuple[PredictedJoint, ...]:
        """All predicted joints, every joint after that of its parent link."""
        found = []
        for link in self.links:
            if link.body is None or link.joint is None or link.parent is None:  # the base
                continue
            best, *others = self.estimate.estimates[link.body]
            alternatives = tuple((other.joint, other.score) for other in others if other.joint is not None)
            parent = self.links[link.parent].name
            given = best.source == OVERRIDE
            found.append(PredictedJoint(link.name, parent, link.joint, best.score, alternatives, link.leaves, given))
        return tuple(found)

    def articulate(self, values: Mapping[str, float]) -> dict[str, NDArray[np.float64]]:
        """Compute the pose of every link for some joint values.

        Args:
            values: Joint values by name of the joint: radians for hinges, lengths of the shape for sliders and screws. Joints
                without a value stay as in the file. A screw does not turn while it slides. Limits do not bound the values.

        Returns:
            For each link by name the rigid transform [4, 4] that takes its points from their place in the file to the new one,
            in the shape's own frame.

        Raises:
            InputError: There is no joint of such a name.
        """
        bodies = {link.name: link.body for link in self.links if link.body is not None}
        for name in values:
            if name not in bodies:
                near, there = did_you_mean(name, bodies), ", ".join(bodies) or "none"
                raise InputError("values", f"expected names of joints, got {name}{near}; there are {there}")
        poses = forward(self.mobility, {bodies[name]: float(value) for name, value in values.items()})
        return {link.name: np.eye(4) if link.body is None else poses[link.body] for link in self.links}

    def articulated(self, values: Mapping[str, float]) -> Shape:
        """Move the links of the shape.

        Args:
            values: Joint values by name of the joint, as in `articulate`.

        Returns:
            The shape with moved meshes, in its own frame. It has no annotation.

        Raises:
            InputError: There is no joint of such a name.
        """
        poses = self.articulate(values)
        parts = list(self.shape.parts)
        for link in self.links:
            rotation, translation = poses[link.name][:3, :3], poses[link.name][:3, 3]
            for leaf in link.leaves:
                mesh = self.shape.leaf_mesh(leaf)
                parts[leaf] = replace(parts[leaf], mesh=mesh.moved(rotation, translation))
        return replace(self.shape, parts=tuple(parts), mobility=None)

    def export(
        self,
        folder: Path | str,
        formats: Sequence[str] = ("urdf",),
        *,
        name: str | None = None,
        metres_per_unit: float | None = None,
        collision: CollisionMode = DEFAULT_MODE,
        physics: Physics | None = None,
        package: str = "",
        overwrite: bool = False,
    ) -> dict[str, Path]:
        """Write the shape with its joints.

        With "joints_json", corrections are written to overrides.toml too.

        Args:
            folder: The folder to write.
            formats: Names of formats (`kinmo.io.writers.WRITERS`): "urdf", "mjcf", "usd", "glb", "joints_json",
                "partnet_mobility".
            name: Name of the model; None for the folder's name.
            metres_per_unit: Length of a unit of the shape's file in metres. None for that of the shape.
            collision: How parts collide: as "convex" pieces, as the "hull" of each part, as their "mesh", or "none".
            physics: Density of the parts, and constants of the joints. None for kinmo's own.
            package: ROS package that the folder will be: URDFs name their files as package://<package>/.... Empty for relative
                paths.
            overwrite: Replace a folder with files in it, as a whole. An overrides.toml in it stays.

        Returns:
            Path of the main file of each format. A warning tells what a format cannot carry, such as the colours of vertices.

        Raises:
            InputError: There is no such format, the folder has files in it or is the current one, `name` is no file name,
                `collision` is unknown, or `metres_per_unit` is not positive.
        """
        folder = Path(folder)
        if folder.resolve() == Path.cwd():
            raise InputError(folder, "is the current folder, which cannot be replaced: name another one")
        if not overwrite and folder.is_dir() and any(folder.iterdir()):
            raise InputError(folder, "has files in it: name another folder, or pass overwrite=True to replace all of them")
        scale = self.shape.metres_per_unit if metres_per_unit is None else metres_per_unit
        if not 0.0 < scale < math.inf:
            raise InputError("metres_per_unit", f"expected a positive number, got {scale}")
        options = ExportOptions(
            name or folder.name,
            scale,
            provenance=self.provenance,
            collision=collision,
            physics=physics or Physics(),
            package=package,
        )
        texts = self._overrides_text(folder) if "joints_json" in formats else {}
        written = write_result(self.shape, self.estimate, folder, formats, options, texts=texts)
        _record(folder, written.files)
        for note in written.notes:
            warnings.warn(note, stacklevel=2)
        return dict(written.main)

    def save(self, folder: Path | str) -> Path:
        """Write joints.json: all joints with scores and alternatives (docs/reference/joints-json.md).

        Corrections are written to overrides.toml too.

        Args:
            folder: The folder to write into. Its other files stay, such as a URDF with other joints: `kinmo export` writes it
                again.

        Returns:
            Path of the file.
        """
        folder = Path(folder)
        saved, scale = options_in(folder), self.shape.metres_per_unit
        formats = tuple(dict.fromkeys((*saved.formats, "joints_json")))
        options = replace(saved, metres_per_unit=scale, provenance=self.provenance, formats=formats)
        for file, text in self._overrides_text(folder).items():
            write_text_atomically(folder / file, text)
        path = write_joints_json(ExportedObject(self.shape, self.estimate, options), folder)
        _record(folder, [path.name])
        return path

    def _overrides_text(self, folder: Path) -> dict[str, str]:
        """Text of overrides.toml by its name. Empty without corrections, or if the file in the folder has the same content."""
        correction = self.estimate.correction
        if correction is None:
            return {}
        with suppress(InputError):
            if read_overrides(folder / OVERRIDES_FILE).table == correction.overrides:
                return {}
        return {OVERRIDES_FILE: overrides_text(correction.overrides)}


def _record(folder: Path, files: Sequence[str]) -> None:
    """If `kinmo predict` wrote the folder first, record that its new files are kinmo's own, and no edits of a person."""
    target = folder.resolve()
    if target.name in Cache(target.parent):
        with locked(target.parent):
            cache = Cache(target.parent)
            known = cache.latest(target.name)
            others = () if known is None else (cache.folder / path for path in known.files)
            cache.renew(target.name, [target / file for file in files], others)
