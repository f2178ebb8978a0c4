"""Labelled frames: what a depth camera saw of an object, and where every point of it belongs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.config import ScansConfig
from kinmo.core.kinematics import forward
from kinmo.scans.articulated_object import ArticulatedObject
from kinmo.scans.camera import Camera, Viewpoints
from kinmo.scans.joint_states import Articulation, articulations
from kinmo.scans.renderers import NOTHING, DepthImages, Renderer, open_renderer
from kinmo.scans.sensor import sense

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]


VIEWPOINTS = Viewpoints()
NEAR, FAR = 0.01, 10.0
"""Diagonals between which a camera sees, as in the pipeline that the paper renders with."""


@dataclass(frozen=True, eq=False)
class Scans:
    """F frames of one object with K parts, n points each. Lengths are diagonals of the object.

    `points` [F, n, 3] are in the camera's frame (`kinmo.scans.camera`), `parts` [F, n] the part that each is of (`NOTHING` for
    what is not of the object), `places` [F, n, 3] where it is on the object in its canonical state, in its normalised frame.
    `poses` [F, K, 4, 4] take every part from there to the camera's frame. `values` and `turns` [F, K - 1] are the states of the
    joints of parts 1 and up (`kinmo.core.kinematics.joint_motion`). `refused` counts frames that are not here, by reason.
    """

    points: F32
    parts: NDArray[np.int16]
    places: F32
    poses: F64
    values: F64
    turns: F64
    refused: Counter[str]

    def __len__(self) -> int:
        return len(self.points)


def scan(
    target: ArticulatedObject, config: ScansConfig, seed: int, *, to_train: bool = True, which: slice = slice(None)
) -> Scans:
    """Frames of `target` from cameras and in states drawn at random, as many as an object to train on, or to test, gets.

    `which` of its states are shown, if not all. Neither the cameras nor the states depend on the sensor.
    """
    states, views = (config.states, config.views) if to_train else (config.test_states, config.test_views)
    rng, sensing = (np.random.default_rng([seed, purpose]) for purpose in range(2))
    camera, refused = Camera.of_field(config.size, config.size, VIEWPOINTS.field, NEAR, FAR), Counter[str]()
    frames: list[_Frame] = []
    with open_renderer(config.renderer, target.meshes) as renderer:
        for state in articulations(target.mobility, states, config.sampling, rng, which):
            for frame in _frames_in_state(target, state, views, renderer, camera, config, rng, sensing):
                if isinstance(frame, str):
                    refused[frame] += 1
                else:
                    frames.append(frame)
    return _stacked(frames, config.points, len(target.meshes), refused)


@dataclass(frozen=True, eq=False)
class _Frame:
    points: F64
    parts: NDArray[np.int64]
    places: F64
    poses: F64
    state: Articulation


def _frames_in_state(
    target: ArticulatedObject,
    state: Articulation,
    views: int,
    renderer: Renderer,
    camera: Camera,
    config: ScansConfig,
    rng: np.random.Generator,
    sensing: np.random.Generator,
) -> Iterator[_Frame | str]:
    moved = forward(target.mobility, state.values, state.turns)
    low, high, floor = _bounds(target, moved)
    if config.cameras == "rest":
        low, high, _ = _bounds(target, np.broadcast_to(np.eye(4), moved.shape))
    center, radius = 0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low))
    cameras = np.stack([VIEWPOINTS.draw(rng, center, radius, target.up) for _ in range(views)])
    poses = cameras[:, None] @ moved
    seen = renderer.render(poses, camera)
    floors = np.array([_plane_in(pose, target.up, floor) for pose in cameras])
    sensed = sense(seen, config.sensor, camera, floors, sensing)
    for row in range(views):
        # by what there is to see: a bad sensor must not get other frames than a good one
        counts = np.array([np.count_nonzero(seen.parts[row] == part) for part in range(len(target.meshes))])
        if counts.min() < config.least_pixels:
            yield f"part {counts.argmin()} has fewer than {config.least_pixels} pixels"
            continue
        if not ((sensed.parts[row] >= 0) & (sensed.depths[row] > 0.0)).any():
            yield "the sensor saw nothing of it"
            continue
        yield _frame(seen, sensed, row, camera, poses[row], state, config.points, sensing)


def _frame(
    seen: DepthImages,
    sensed: DepthImages,
    row: int,
    camera: Camera,
    poses: F64,
    state: Articulation,
    count: int,
    rng: np.random.Generator,
) -> _Frame:
    """Points drawn from one picture; their places are those of what was truly seen, whatever the sensor made of it."""
    pixels = np.flatnonzero(sensed.depths[row].ravel() > 0.0)
    chosen = rng.choice(pixels, count, replace=len(pixels) < count)
    parts = sensed.parts[row].ravel()[chosen].astype(np.int64)
    points = camera.points(sensed.depths[row].ravel()[chosen], chosen)
    true = camera.points(seen.depths[row].ravel()[chosen], chosen)
    back = np.linalg.inv(poses)[np.maximum(parts, 0)]
    places = np.einsum("nij,nj->ni", back[:, :3, :3], true) + back[:, :3, 3]
    places[parts == NOTHING] = 0.0
    return _Frame(points, parts, places, poses, state)


def _bounds(target: ArticulatedObject, moved: F64) -> tuple[F64, F64, float]:
    """Corners of the box along the axes about the moved parts, and their least height."""
    lows, highs, floors = [], [], []
    for mesh, pose in zip(target.meshes, moved, strict=True):
        rows = pose[:3, :3] @ mesh.vertices.T + pose[:3, 3:]  # [3, N]: extremes along rows are many times faster
        lows.append(rows.min(axis=1))
        highs.append(rows.max(axis=1))
        floors.append((target.up @ rows).min())
    return np.min(lows, axis=0), np.max(highs, axis=0), float(min(floors))


def _plane_in(pose: F64, up: F64, height: float) -> F64:
    """The plane up . x = height, in the frame that `pose` takes to."""
    normal = pose[:3, :3] @ up
    return np.array([*normal, height + normal @ pose[:3, 3]])


def _stacked(frames: list[_Frame], count: int, parts: int, refused: Counter[str]) -> Scans:
    joints, rows = range(1, parts), len(frames)
    values = [[frame.state.values[joint] for joint in joints] for frame in frames]
    turns = [[frame.state.turns.get(joint, 0.0) for joint in joints] for frame in frames]
    return Scans(
        np.array([frame.points for frame in frames], np.float32).reshape(rows, count, 3),
        np.array([frame.parts for frame in frames], np.int16).reshape(rows, count),
        np.array([frame.places for frame in frames], np.float32).reshape(rows, count, 3),
        np.array([frame.poses for frame in frames], np.float64).reshape(rows, parts, 4, 4),
        np.array(values, np.float64).reshape(rows, parts - 1),
        np.array(turns, np.float64).reshape(rows, parts - 1),
        refused,
    )
