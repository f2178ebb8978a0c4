"""Labelled frames: points that a depth camera sees of an object, each with its part and its canonical position."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.config import ScansConfig
from kinmo.core.kinematics import forward
from kinmo.scans.canonical.articulated_object import ArticulatedObject
from kinmo.scans.rendering.joint_states import JointStates, sample_joint_states
from kinmo.scans.rendering.pinhole_camera import Camera, Viewpoints
from kinmo.scans.rendering.renderers import NO_PART, DepthImages, Renderer, open_renderer
from kinmo.scans.rendering.sensor import apply_sensor

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]

VIEWPOINTS = Viewpoints()
NEAR, FAR = 0.01, 10.0
"""Visible depths in diagonals, as in the paper's rendering pipeline."""


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
        target: The object.
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
    skipped = Counter[str]()
    frames: list[_Frame] = []
    with open_renderer(config.renderer, target.meshes) as renderer:
        for state in sample_joint_states(target.mobility, states, rng, subset, like_release=config.release):
            for frame in _frames_in_state(target, state, views, renderer, camera, config, rng, sensor_rng):
                if isinstance(frame, str):
                    skipped[frame] += 1
                else:
                    frames.append(frame)
    return _stacked(frames, config.points, len(target.meshes), skipped)


@dataclass(frozen=True, eq=False)
class _Frame:
    points: F64
    parts: NDArray[np.int64]
    places: F64
    poses: F64
    state: JointStates


def _frames_in_state(
    target: ArticulatedObject,
    state: JointStates,
    views: int,
    renderer: Renderer,
    camera: Camera,
    config: ScansConfig,
    rng: np.random.Generator,
    sensor_rng: np.random.Generator,
) -> Iterator[_Frame | str]:
    """Frames from `views` cameras, each one a frame or the reason to skip it."""
    moved = forward(target.mobility, state.values, state.turns)
    low, high, floor = _bounds(target, moved)
    if config.release:
        low, high, _ = _bounds(target, np.broadcast_to(np.eye(4), moved.shape))
    center, radius = 0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low))
    cameras = np.stack([VIEWPOINTS.sample(rng, center, radius, target.up) for _ in range(views)])
    poses = cameras[:, None] @ moved
    rendered = renderer.render(poses, camera)
    floors = np.array([_plane_in(pose, target.up, floor) for pose in cameras])
    sensed = apply_sensor(rendered, config.sensor, camera, floors, sensor_rng)
    for row in range(views):
        # Count rendered pixels, so that a noisy sensor and an ideal one keep the same frames.
        counts = np.array([np.count_nonzero(rendered.parts[row] == part) for part in range(len(target.meshes))])
        if counts.min() < config.least_pixels:
            yield f"part {counts.argmin()} has fewer than {config.least_pixels} pixels"
            continue
        if not ((sensed.parts[row] >= 0) & (sensed.depths[row] > 0.0)).any():
            yield "the sensor saw nothing of it"
            continue
        yield _frame(rendered, sensed, row, camera, poses[row], state, config.points, sensor_rng)


def _frame(
    rendered: DepthImages,
    sensed: DepthImages,
    row: int,
    camera: Camera,
    poses: F64,
    state: JointStates,
    count: int,
    rng: np.random.Generator,
) -> _Frame:
    """Points drawn from one sensed image; their canonical positions come from the rendered one."""
    pixels = np.flatnonzero(sensed.depths[row].ravel() > 0.0)
    chosen = rng.choice(pixels, count, replace=len(pixels) < count)
    parts = sensed.parts[row].ravel()[chosen].astype(np.int64)
    points = camera.back_project(sensed.depths[row].ravel()[chosen], chosen)
    true = camera.back_project(rendered.depths[row].ravel()[chosen], chosen)
    back = np.linalg.inv(poses)[np.maximum(parts, 0)]
    places = np.einsum("nij,nj->ni", back[:, :3, :3], true) + back[:, :3, 3]
    places[parts == NO_PART] = 0.0
    return _Frame(points, parts, places, poses, state)


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


def _stacked(frames: list[_Frame], count: int, parts: int, skipped: Counter[str]) -> LabelledFrames:
    joints, rows = range(1, parts), len(frames)
    values = [[frame.state.values[joint] for joint in joints] for frame in frames]
    turns = [[frame.state.turns.get(joint, 0.0) for joint in joints] for frame in frames]
    return LabelledFrames(
        np.array([frame.points for frame in frames], np.float32).reshape(rows, count, 3),
        np.array([frame.parts for frame in frames], np.int16).reshape(rows, count),
        np.array([frame.places for frame in frames], np.float32).reshape(rows, count, 3),
        np.array([frame.poses for frame in frames], np.float64).reshape(rows, parts, 4, 4),
        np.array(values, np.float64).reshape(rows, parts - 1),
        np.array(turns, np.float64).reshape(rows, parts - 1),
        skipped,
    )
