"""Labelled frames: points that a depth camera sees of an object, each with its part and its canonical position."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.config import ScansConfig
from kinmo.core.joint import Joint, JointKind
from kinmo.core.kinematics import forward
from kinmo.core.mobility import Mobility
from kinmo.scans.canonical.articulated_object import ArticulatedObject
from kinmo.scans.rendering.pinhole_camera import Camera, Viewpoints
from kinmo.scans.rendering.renderers import NO_PART, DepthImages, open_renderer
from kinmo.scans.rendering.sensor import apply_sensor

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]

VIEWPOINTS = Viewpoints()
NEAR, FAR = 0.01, 10.0
"""Visible depths in diagonals, as in the paper's rendering pipeline."""
DEFAULT_RANGE = (-0.5 * math.pi, 0.5 * math.pi)
"""Range of a hinge without limits around its rest, and of a screw's turn; rad."""
RELEASE_ANGLES, RELEASE_SHIFTS = (math.radians(-90.0), math.radians(30.0)), (0.0, 0.4)
"""Ranges of all hinges (rad) and all sliders (diagonals) in the paper's release, whatever their limits."""


@dataclass(frozen=True, eq=False)
class LabelledFrames:
    """F frames of one object with K parts and n points each; lengths are diagonals of the object.

    Attributes:
        points: Points [F, n, 3] in the camera frame.
        parts: Part [F, n] of each point, or `NO_PART`.
        places: Canonical positions [F, n, 3] of the points: on the object in its canonical pose, in its normalised frame.
        poses: Poses [F, K, 4, 4] of the parts, from the canonical pose to the camera frame.
        values: Values [F, K - 1] of the joints of parts 1 and up.
        turns: Turns [F, K - 1] of the same joints, rad (`kinmo.core.kinematics.joint_motion`).
        skipped: Number of skipped frames by reason.
    """

    points: F32
    parts: NDArray[np.int16]
    places: F32
    poses: F64
    values: F64
    turns: F64
    skipped: Counter[str]

    def __len__(self) -> int:
        return len(self.points)


def scan_object(
    target: ArticulatedObject, config: ScansConfig, seed: int, *, to_train: bool = True, subset: slice = slice(None)
) -> LabelledFrames:
    """Scan an object in random joint states from random viewpoints.

    Args:
        config: Numbers of states and views, image size, renderer and sensor. Cameras and states do not depend on the sensor.
        seed: Seed of all random numbers.
        to_train: True for the numbers of states and views of training objects, False for those of test objects.
        subset: Selects some of the joint states.

    Returns:
        The frames in which each part has at least `config.least_pixels` pixels, and the number of skipped ones by reason.
    """
    states, views = (config.states, config.views) if to_train else (config.test_states, config.test_views)
    rng, sensor_rng = (np.random.default_rng([seed, purpose]) for purpose in range(2))
    camera = Camera.from_field_of_view(config.size, config.size, VIEWPOINTS.field_of_view, NEAR, FAR)
    skipped, frames = Counter[str](), list[tuple[object, ...]]()
    joints = range(1, len(target.meshes))
    with open_renderer(config.renderer, target.meshes) as renderer:
        for values, turns in sample_joint_states(target.mobility, states, rng, subset, like_release=config.release):
            moved = forward(target.mobility, values, turns)
            cameras, floors = _cameras(target, moved, views, config.release, rng)
            poses = cameras[:, None] @ moved
            rendered = renderer.render(poses, camera)
            sensed = apply_sensor(rendered, config.sensor, camera, floors, sensor_rng)
            state = [values[joint] for joint in joints], [turns.get(joint, 0.0) for joint in joints]
            for row in range(views):
                reason = _reason_to_skip(rendered, sensed, row, len(target.meshes), config.least_pixels)
                if reason:
                    skipped[reason] += 1
                    continue
                sampled = _sampled_points(rendered, sensed, row, camera, poses[row], config.points, sensor_rng)
                frames.append((*sampled, poses[row], *state))
    return _stacked(frames, config.points, len(target.meshes), skipped)


def joint_range(joint: Joint) -> tuple[float, float]:
    """Limits of a joint. A hinge without limits turns a quarter to either side of its rest; other joints stay."""
    if joint.lower is not None and joint.upper is not None:
        return joint.lower, joint.upper
    if joint.kind is JointKind.REVOLUTE:
        return joint.rest + DEFAULT_RANGE[0], joint.rest + DEFAULT_RANGE[1]
    return joint.rest, joint.rest


def sample_joint_states(
    mobility: Mobility, count: int, rng: np.random.Generator, subset: slice = slice(None), *, like_release: bool = False
) -> Iterator[tuple[dict[int, float], dict[int, float]]]:
    """Values and turns of all joints by body index, in `count` sampled states of which `subset` selects some.

    Each value is drawn from its joint's range. With `like_release` all joints move in equal steps through `RELEASE_ANGLES` and
    `RELEASE_SHIFTS`.
    """
    joints = {index: body.joint for index, body in mobility.movable() if body.joint is not None}
    ranges = {index: joint_range(joint) for index, joint in joints.items()}
    if like_release:
        limits = {i: RELEASE_ANGLES if j.kind is JointKind.REVOLUTE else RELEASE_SHIFTS for i, j in joints.items()}
        ranges = {i: (low + joints[i].rest, high + joints[i].rest) for i, (low, high) in limits.items()}
    screws = [index for index, joint in joints.items() if joint.kind is JointKind.SCREW]

    def sample(limits: tuple[float, float], step: float) -> float:
        share = float(step if like_release else rng.uniform())
        return (1.0 - share) * limits[0] + share * limits[1]

    for step in np.linspace(0.0, 1.0, count)[subset]:
        values = {index: sample(limits, step) for index, limits in ranges.items()}
        yield values, {index: sample(DEFAULT_RANGE, step) for index in screws}


def _cameras(target: ArticulatedObject, moved: F64, count: int, release: bool, rng: np.random.Generator) -> tuple[F64, F64]:
    """Camera poses [count, 4, 4] around an object whose parts have the poses `moved`, and the floor [count, 4] in each."""
    low, high, floor = _bounds(target, moved)
    if release:
        low, high, _ = _bounds(target, np.broadcast_to(np.eye(4), moved.shape))
    center, radius = 0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low))
    cameras = np.stack([VIEWPOINTS.sample(rng, center, radius, target.up) for _ in range(count)])
    return cameras, np.array([_plane_in(pose, target.up, floor) for pose in cameras])


def _reason_to_skip(rendered: DepthImages, sensed: DepthImages, row: int, part_count: int, least_pixels: int) -> str | None:
    """Reason to skip a frame. Rendered pixels count, so that a noisy sensor and an ideal one keep the same frames."""
    counts = np.array([np.count_nonzero(rendered.parts[row] == part) for part in range(part_count)])
    if counts.min() < least_pixels:
        return f"part {counts.argmin()} has fewer than {least_pixels} pixels"
    is_seen = ((sensed.parts[row] >= 0) & (sensed.depths[row] > 0.0)).any()
    return None if is_seen else "the sensor saw nothing of it"


def _sampled_points(
    rendered: DepthImages, sensed: DepthImages, row: int, camera: Camera, poses: F64, count: int, rng: np.random.Generator
) -> tuple[F64, NDArray[np.int64], F64]:
    """Points drawn from one sensed image, with their parts; their canonical positions come from the rendered image."""
    pixels = np.flatnonzero(sensed.depths[row].ravel() > 0.0)
    chosen = rng.choice(pixels, count, replace=len(pixels) < count)
    parts = sensed.parts[row].ravel()[chosen].astype(np.int64)
    points = camera.back_project(sensed.depths[row].ravel()[chosen], chosen)
    true = camera.back_project(rendered.depths[row].ravel()[chosen], chosen)
    back = np.linalg.inv(poses)[np.maximum(parts, 0)]
    places = np.einsum("nij,nj->ni", back[:, :3, :3], true) + back[:, :3, 3]
    places[parts == NO_PART] = 0.0
    return points, parts, places


def _bounds(target: ArticulatedObject, moved: F64) -> tuple[F64, F64, float]:
    """Corners of the axis-aligned box of the moved parts, and their smallest height."""
    lows, highs, floors = [], [], []
    for mesh, pose in zip(target.meshes, moved, strict=True):
        rows = pose[:3, :3] @ mesh.vertices.T + pose[:3, 3:]  # [3, N]: extremes along rows are many times faster
        lows.append(rows.min(axis=1))
        highs.append(rows.max(axis=1))
        floors.append((target.up @ rows).min())
    return np.min(lows, axis=0), np.max(highs, axis=0), float(min(floors))


def _plane_in(pose: F64, up: F64, height: float) -> F64:
    """The plane up . x = height as (normal, offset) [4] in the frame that `pose` maps to."""
    normal = pose[:3, :3] @ up
    return np.array([*normal, height + normal @ pose[:3, 3]])


def _stacked(frames: Sequence[tuple[object, ...]], points: int, parts: int, skipped: Counter[str]) -> LabelledFrames:
    """Frames as arrays, in the order of `LabelledFrames`."""
    shapes = (points, 3), (points,), (points, 3), (parts, 4, 4), (parts - 1,), (parts - 1,)
    columns = zip(*frames, strict=True) if frames else [()] * len(shapes)
    arrays = [np.array(own).reshape(len(frames), *shape) for own, shape in zip(columns, shapes, strict=True)]
    types = np.float32, np.int16, np.float32, np.float64, np.float64, np.float64
    seen, labels, places, poses, values, turns = (array.astype(kind) for array, kind in zip(arrays, types, strict=True))
    return LabelledFrames(seen, labels, places, poses, values, turns, skipped)
