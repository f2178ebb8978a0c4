"""An object to look at: bodies with their parts in colours, and the ranked joints of each body.

The frame is that of GLB files: y up, in the length unit of the shape. The value of a joint is 0 in the pose of the file.
"""

from __future__ import annotations

import base64
import gzip
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo.api.prediction import Prediction
from kinmo.core.frames import y_up_rotation, z_up_rotation
from kinmo.core.joint import KIND_WORDS, Joint, JointKind
from kinmo.core.kinematics import forward
from kinmo.core.mobility import Body, Mobility
from kinmo.core.overrides import FIXED
from kinmo.core.references import NUMBER_SIGN, body_labels
from kinmo.core.shape import Mesh, Shape, bounds_of
from kinmo.core.shape_estimate import OVERRIDE, JointEstimate
from kinmo.core.vector import Vector
from kinmo.core.wording import clean_text, counted
from kinmo.io.writers.glb_writer import FROM_ROBOT, glb_bytes
from kinmo.robot.robot import Robot
from kinmo.robot.robot_builder import build_robot
from kinmo.view.axis_words import joint_words
from kinmo.view.body_colors import Color, body_colors

OVERHANG = 0.07
"""Length of an axis beyond its body, in diagonals of the object."""


@dataclass(frozen=True, eq=False)
class SceneOption:
    """One way in which a body may move.

    Attributes:
        label: short text for people, such as "1. hinge, vertical, left edge 0.82", with the rank first. All of a body differ.
        joint: the joint in the frame of the scene. Its rest value is 0. None for a body that does not move.
        probability: score of the joint. None if nobody stated one.
        rank: rank among the predicted joints, as overrides.toml counts. None for a joint that was not predicted.
    """

    label: str
    joint: Joint | None
    probability: float | None = None
    rank: int | None = None


@dataclass(frozen=True, eq=False)
class SceneBody:
    """A rigid body.

    Attributes:
        name: its name, for people. Bodies of the same name have their number in it.
        parent: index of the body that it is attached to.
        leaves: indices of its parts in `Shape.parts`.
        color: [3] colour of its parts, in 0..1.
        options: the ranked joints. Empty for a body whose joint nobody estimated.
        chosen: index of the present joint among them.
        key: reference to the body in overrides.toml. None if it cannot be corrected there.
    """

    name: str
    parent: int | None
    leaves: tuple[int, ...]
    color: Color
    options: tuple[SceneOption, ...] = ()
    chosen: int = 0
    key: str | None = None

    @property
    def option(self) -> SceneOption | None:
        """The present joint."""
        return self.options[self.chosen] if self.options else None

    @property
    def joint(self) -> Joint | None:
        """The present joint, or None for a body that does not move."""
        return None if self.option is None else self.option.joint


@dataclass(frozen=True, eq=False)
class ObjectScene:
    """An object with everything that a viewer shows.

    Attributes:
        name: name of the object.
        facts: one line about it.
        shape: the shape, in its own frame.
        bodies: its bodies.
        notes: repairs and guesses of the reader, and consequences of corrections.
        is_predicted: True if the joints were predicted. Others are those of the file.
    """

    name: str
    facts: str
    shape: Shape
    bodies: tuple[SceneBody, ...]
    notes: tuple[str, ...] = ()
    is_predicted: bool = False

    @property
    def rotation(self) -> NDArray[np.float64]:
        """Rotation [3, 3] from the frame of the shape to that of the scene."""
        return np.asarray(FROM_ROBOT @ z_up_rotation(np.asarray(self.shape.up, float)))

    @property
    def front(self) -> Vector:
        """Unit vector [3] towards the viewer, in the frame of the scene."""
        known = None if self.shape.front is None else np.asarray(self.shape.front, float)
        return np.asarray(self.rotation @ y_up_rotation(np.asarray(self.shape.up, float), known)[2])

    @property
    def unit(self) -> str:
        """Name of the length unit."""
        return "m" if self.shape.metres_per_unit == 1.0 else "units"

    @cached_property
    def robot(self) -> Robot:
        """The parts as GLB has them, below one link for each group of bodies that move as one."""
        return build_robot(self.shape, self.mobility.rotated(self.rotation.T))

    @cached_property
    def meshes(self) -> dict[int, Mesh]:
        """Meshes of the parts in the frame of the scene, in the pose of the file, by their indices in `Shape.parts`."""
        return {leaf: self.shape.leaf_mesh(leaf).rotated(self.rotation) for body in self.bodies for leaf in body.leaves}

    @cached_property
    def bounds(self) -> tuple[Vector, Vector]:
        """Smallest and largest corner [3] in the pose of the file."""
        return bounds_of(self.meshes.values())

    @property
    def mobility(self) -> Mobility:
        """The bodies with their present joints, in the frame of the scene."""
        return Mobility(
            tuple(
                Body(index, body.name, body.leaves, body.parent, None if body.parent is None else body.joint)
                for index, body in enumerate(self.bodies)
            )
        )

    def poses(self, values: Mapping[int, float]) -> NDArray[np.float64]:
        """Poses [B, 4, 4] of all bodies, as transforms from the pose of the file.

        Args:
            values: Joint values in radians or lengths, by index of the body. A joint without a value stays at 0.
        """
        return forward(self.mobility, values)

    def range_of(self, index: int) -> tuple[float, float]:
        """Smallest and largest value of the joint of a body. A joint without limits gets a turn, or the object's radius."""
        joint = self.bodies[index].joint
        assert joint is not None, "only moving bodies have a range"
        low, high = self.bounds
        largest = math.pi if joint.kind is JointKind.REVOLUTE else 0.5 * float(np.linalg.norm(high - low))
        return (-largest if joint.lower is None else joint.lower), (largest if joint.upper is None else joint.upper)

    def opened(self, share: float) -> dict[int, float]:
        """Values of all joints at a share of the way from the pose of the file to their farther limit.

        Joints without limits make a quarter of a turn, or move by a quarter of the object's size.
        """
        values = {}
        for index, body in enumerate(self.bodies):
            if body.joint is not None and body.parent is not None:
                lower, upper = self.range_of(index)
                lower, upper = (lower, upper) if body.joint.is_limited else (0.0, 0.5 * upper)
                values[index] = share * (upper if abs(upper) >= abs(lower) else lower)
        return values

    def axis_ends(self, index: int) -> NDArray[np.float64]:
        """Begin and end [2, 3] of an arrow that shows the joint of a body, in the pose of the file.

        It runs along the axis over the extent of the body. That of a slider runs through the middle of the body.
        """
        body, (low, high) = self.bodies[index], self.bounds
        joint = body.joint
        assert joint is not None, "only moving bodies have an axis"
        first, last = bounds_of(self.meshes[leaf] for leaf in body.leaves) if body.leaves else (low, high)
        through = joint.pivot if joint.has_pivot else 0.5 * (first + last)
        corners = np.array(list(product(*zip(first, last, strict=True))))
        along = (corners - through) @ joint.direction
        overhang = OVERHANG * float(np.linalg.norm(high - low))
        ends = np.array([along.min() - overhang, along.max() + overhang])
        return np.asarray(through + ends[:, None] * joint.direction)

    def glb(self) -> bytes:
        """The geometry with its looks, as GLB."""
        return glb_bytes(self.robot)

    @cached_property
    def has_looks(self) -> bool:
        """True if the file gives a part a colour or a texture."""
        glb = self.glb()
        document = json.loads(glb[20 : 20 + int.from_bytes(glb[12:16], "little")])
        surfaces = (material.get("pbrMetallicRoughness", {}) for material in document.get("materials", []))
        primitives = (each for mesh in document.get("meshes", []) for each in mesh["primitives"])
        return any("baseColorFactor" in each or "baseColorTexture" in each for each in surfaces) or any(
            "COLOR_0" in each["attributes"] for each in primitives
        )

    def to_data(self) -> dict[str, Any]:
        """The scene as plain data, for `object_viewer.js`. The GLB is compressed."""
        nodes = {visual.leaf: visual.name for link in self.robot.links for visual in link.visuals}
        parts = self.shape.parts
        packed = gzip.compress(self.glb(), mtime=0)
        return {
            "name": clean_text(self.name),
            "facts": self.facts,
            "notes": [clean_text(note) for note in self.notes],
            "unit": self.unit,
            "front": self.front.tolist(),
            "bodies": [
                {
                    "name": body.name,
                    "key": body.key,
                    "parent": body.parent,
                    "color": list(body.color),
                    "parts": [{"name": clean_text(parts[i].name) or nodes[i], "node": nodes[i]} for i in body.leaves],
                    "options": [_option_data(option) for option in body.options],
                    "chosen": body.chosen,
                }
                for body in self.bodies
            ],
            "glb": base64.b64encode(packed).decode("ascii"),
        }

    def to_json(self) -> str:
        """`to_data` as JSON that may stand in a script element of a page."""
        return json.dumps(self.to_data(), separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def scene_of(item: Prediction | Shape) -> ObjectScene:
    """The scene of a prediction, or of a shape with the joints of its annotation.

    Args:
        item: The prediction or the shape.

    Returns:
        The scene. Angles are in radians and lengths in the unit of the shape.
    """
    return _scene_of_shape(item) if isinstance(item, Shape) else _scene_of_prediction(item)


def _scene_of_shape(shape: Shape) -> ObjectScene:
    mobility = shape.mobility or Mobility((Body(0, "object", shape.leaves),))
    options = [(SceneOption("", body.joint),) if body.joint is not None else () for body in mobility.bodies]
    return _scene(shape, mobility, options, [0] * len(options), [None] * len(options), ())


def _scene_of_prediction(prediction: Prediction) -> ObjectScene:
    estimate = prediction.estimate
    before = estimate.predicted
    ranked = {body.id: ranks for body, ranks in zip(before.mobility.bodies, before.estimates, strict=True)}
    names = {body.id: body.name for body in before.mobility.bodies}
    clear = {number for number, label in body_labels(names).items() if label == names[number]}
    options, chosen, keys = [], [], []
    for body, estimates in zip(estimate.mobility.bodies, estimate.estimates, strict=True):
        own = [_option(each, rank) for rank, each in enumerate(ranked.get(body.id, ()), 1)]
        if estimates and estimates[0].source == OVERRIDE:
            own.insert(0, SceneOption("", body.joint, None))
        options.append(tuple(own))
        chosen.append(_place_of(body, own))
        keys.append(None if body.id not in names else names[body.id] if body.id in clear else f"{NUMBER_SIGN}{body.id}")
    notes = () if estimate.correction is None else estimate.correction.notes
    return _scene(prediction.shape, estimate.mobility, options, chosen, keys, notes, True)


def _option(estimate: JointEstimate, rank: int) -> SceneOption:
    return SceneOption("", estimate.joint, estimate.score, rank)


def _place_of(body: Body, options: Sequence[SceneOption]) -> int:
    """Index of the option that is the present joint of a body: the first one that moves as it does."""
    same = (place for place, option in enumerate(options) if (option.joint is None) == (body.joint is None))
    return next(same, 0)


def _scene(
    shape: Shape,
    mobility: Mobility,
    options: Sequence[tuple[SceneOption, ...]],
    chosen: Sequence[int],
    keys: Sequence[str | None],
    notes: Iterable[str],
    is_predicted: bool = False,
) -> ObjectScene:
    notes = (*notes, *shape.repairs, *(f"guessed: {guess}" for guess in shape.guesses.values()))
    scene = ObjectScene(shape.id, _facts(shape, mobility), shape, (), notes, is_predicted)
    labels = body_labels({place: body.name for place, body in enumerate(mobility.bodies)})
    colors = body_colors([body.joint is not None for body in mobility.bodies])
    bodies = []
    for index, body in enumerate(mobility.bodies):
        own = tuple(_placed(option, scene, body) for option in options[index])
        bodies.append(SceneBody(labels[index], body.parent, body.leaves, colors[index], own, chosen[index], keys[index]))
    return replace(scene, bodies=tuple(bodies))


def _placed(option: SceneOption, scene: ObjectScene, body: Body) -> SceneOption:
    """An option with its joint in the frame of the scene and a label."""
    joint = option.joint
    score = "" if option.probability is None else f" {option.probability:.2f}"
    rank = "" if option.rank is None else f"{option.rank}. "
    if joint is None:
        return replace(option, label=f"{rank}{FIXED}{score}" if option.rank else f"{FIXED}, by hand")
    shape = scene.shape
    leaves = body.leaves or shape.leaves
    words = joint_words(joint, bounds_of(shape.leaf_mesh(leaf) for leaf in leaves), shape.up, shape.front)
    limits = (None if end is None else end - joint.rest for end in (joint.lower, joint.upper))
    lower, upper = limits
    placed = replace(joint.rotated(scene.rotation), lower=lower, upper=upper, rest=0.0)
    hand = ", by hand" if option.rank is None and scene.is_predicted else ""
    return replace(option, joint=placed, label=f"{rank}{words}{hand}{score}")


def _option_data(option: SceneOption) -> dict[str, Any]:
    joint = option.joint
    facts = {"label": option.label, "probability": option.probability, "rank": option.rank}
    if joint is None:
        return {**facts, "kind": None}
    return {
        **facts,
        "kind": KIND_WORDS[joint.kind],
        "axis": joint.direction.tolist(),
        "pivot": joint.pivot.tolist(),
        "lower": joint.lower,
        "upper": joint.upper,
    }


def _facts(shape: Shape, mobility: Mobility) -> str:
    joints = sum(body.joint is not None for body in mobility.bodies)
    category = clean_text(shape.category)
    counts = [counted(len(shape.leaves), "part"), counted(joints, "joint")]
    return ", ".join([*([category] if category else []), *counts])
