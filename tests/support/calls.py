"""One small valid call of every function of `kinmo._core`, by name, for tests of what holds for all of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from solids import BOX, CYLINDER, meshes

from kinmo import _core

Arrays = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class Call:
    """A function that takes keywords, and the arrays among its arguments."""

    run: Callable[..., object]
    arrays: Arrays

    def outcome(self, **changed: object) -> list[NDArray[Any]]:
        """The arrays that it returns."""
        return arrays_of(self.run(**{**self.arrays, **changed}))


def arrays_of(result: object) -> list[NDArray[Any]]:
    """Results of a function, as arrays."""
    if isinstance(result, _core.InteractionRegions):
        return [getattr(result, name) for name in ("centroids", "scored", "touching", "offsets", "samples", "weights")]
    return list(result) if isinstance(result, tuple) else [result]


def _calls() -> dict[str, Call]:
    rng = np.random.default_rng(0)
    parts = meshes(BOX, (CYLINDER[0] + [3.0, 0.5, 0.0], CYLINDER[1]))
    joints: Arrays = {
        "kinds": np.array([0, 1, 2], np.uint8),
        "directions": np.linalg.qr(rng.normal(size=(3, 3)))[0],
        "pivots": rng.normal(size=(3, 3)),
    }
    boxes: Arrays = {}
    for side in "ab":
        boxes[f"centers_{side}"] = rng.normal(size=(3, 3)) * 0.2
        boxes[f"axes_{side}"] = np.linalg.qr(rng.normal(size=(3, 3, 3)))[0]
        boxes[f"half_{side}"] = rng.uniform(0.5, 1.0, (3, 3))
    pairs = np.array([[0, 1], [1, 0], [0, 1]], np.uint32)
    clouds = np.stack([rng.uniform(size=(40, 3)), rng.uniform(size=(40, 3)) + [0.9, 0.0, 0.0]])
    motion: Arrays = {"points": rng.normal(size=(7, 3)).astype(np.float32), **joints}
    motion |= {"angles": rng.normal(size=(3, 2)), "shifts": rng.normal(size=(3, 2))}
    travels: Arrays = {**joints, "lower": -np.ones(3), "upper": np.ones(3), "pitches": np.full(3, 0.1)}
    return _scan_calls(parts) | {
        "Meshes": Call(
            lambda vertices, faces: _core.fit_boxes(_core.Meshes([vertices], [faces])), {"vertices": BOX[0], "faces": BOX[1]}
        ),
        "fit_aligned_boxes": Call(
            lambda frame: _core.fit_aligned_boxes(parts, frame), {"frame": joints["directions"] * _sign(joints)}
        ),
        "part_distances": Call(lambda pairs: _core.part_distances(parts, pairs=pairs), {"pairs": pairs}),
        "interaction_regions": Call(_core.interaction_regions, {"points": clouds, "pairs": pairs}),
        "move_points": Call(_core.move_points, motion),
        "sweep": Call(lambda **arrays: _core.sweep(parts, [0], [1], **arrays), travels),
        "box_intersection_volume": Call(_core.box_intersection_volume, boxes),
        "box_iou": Call(_core.box_iou, boxes),
        "closest_points": Call(lambda points: _core.closest_points(parts, [0, 1], points), {"points": clouds[0]}),
        "closest_points_of_groups": Call(
            lambda points: _core.closest_points_of_groups(parts, [[0], [1, 0]], points), {"points": clouds}
        ),
    }


def _scan_calls(parts: _core.Meshes) -> dict[str, Call]:
    """Calls that see and place parts in scans: two objects of two parts each, tied by a joint."""
    rng = np.random.default_rng(1)
    cloud = rng.uniform(size=(80, 3))
    points: Arrays = {
        "source": cloud,
        "target": 0.5 * cloud @ np.linalg.qr(rng.normal(size=(3, 3)))[0] + [0.0, 0.0, 2.0],
        "offsets": np.array([0, 20, 40, 60, 80]),
    }
    joints: Arrays = {
        "pairs": np.array([[0, 1], [2, 3]], np.uint32),
        "kinds": np.array([0, 1], np.uint8),
        "directions": np.eye(3)[:2],
    }
    turns = np.stack([np.eye(3)] * 4)
    poses: Arrays = {"rotations": turns, "scales": np.full(4, 0.5), "translations": rng.normal(size=(4, 3))}
    objects: Arrays = {"frames": np.array([0, 2, 4])}
    known: Arrays = {"ranges": np.array([[0.0, 1.0], [-1.0, 0.0]]), "axis_aligned": np.array([True, False, True, False])}
    search: dict[str, Any] = {"hypotheses": 50, "threshold": 0.05, "seed": 3}
    camera = np.eye(4)[None, None].repeat(2, axis=1) + np.eye(4, k=3) * [0.0, 0.0, 0.0, 1.0]
    camera[..., 2, 3] = 9.0
    return {
        "render": Call(
            lambda **arrays: _core.render(parts, size=(16, 12), near=0.1, far=50.0, **arrays),
            {"transforms": camera, "focal": np.array([12.0, 12.0]), "center": np.array([8.0, 6.0])},
        ),
        "manhattan_frames": Call(
            _core.manhattan_frames,
            {"points": rng.uniform(size=(2, 30, 3)).astype(np.float32), "mask": np.arange(60).reshape(2, 30) % 5 > 0},
        ),
        "nearest_neighbours": Call(
            lambda points: _core.nearest_neighbours(points, 5), {"points": rng.uniform(size=(2, 30, 3)).astype(np.float32)}
        ),
        "find_similarities": Call(lambda **arrays: _flat(_core.find_similarities(**arrays, **search)), points),
        "fit_constrained_poses": Call(
            lambda **arrays: _core.fit_constrained_poses(**arrays, threshold=0.05), {**points, **joints, **poses, **objects}
        ),
        "refine_poses": Call(
            lambda **arrays: _core.refine_poses(**arrays, threshold=0.05), {**points, **joints, **known, **poses, **objects}
        ),
        "find_constrained_poses": Call(
            lambda **arrays: _flat(_core.find_constrained_poses(**arrays, **search)),
            {**points, **joints, "scales": poses["scales"]},
        ),
        "adjust_amodal_boxes": Call(
            _core.adjust_amodal_boxes,
            {
                "points": cloud,
                "offsets": np.array([0, 40, 80]),
                "owners": np.arange(80) // 10 % 2,
                "cameras": np.zeros((2, 3)),
                "centers": rng.normal(size=(4, 3)),
                "axes": turns,
                "half": np.full((4, 3), 0.3),
                **objects,
            },
        ),
    }


def _flat(result: tuple[Any, ...]) -> tuple[NDArray[Any], ...]:
    """Arrays of tuples of arrays."""
    return tuple(array for one in result for array in (one if isinstance(one, tuple) else (one,)))


def _sign(joints: Arrays) -> float:
    return float(np.sign(np.linalg.det(joints["directions"])))


CALLS = _calls()
ARGUMENTS = [(name, argument) for name, call in CALLS.items() for argument in call.arrays]
