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
    """What a function returned, as arrays."""
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
    return {
        "Meshes": Call(
            lambda vertices, faces: _core.fit_boxes(_core.Meshes([vertices], [faces])), {"vertices": BOX[0], "faces": BOX[1]}
        ),
        "fit_aligned_boxes": Call(
            lambda frame: _core.fit_aligned_boxes(parts, frame), {"frame": joints["directions"] * _sign(joints)}
        ),
        "fit_upright_boxes": Call(lambda up: _core.fit_upright_boxes(parts, up), {"up": np.array([0.0, 1.0, 0.5])}),
        "part_distances": Call(lambda pairs: _core.part_distances(parts, pairs=pairs), {"pairs": pairs}),
        "interaction_regions": Call(_core.interaction_regions, {"points": clouds, "pairs": pairs}),
        "move_points": Call(_core.move_points, motion),
        "sweep": Call(lambda **arrays: _core.sweep(parts, [0], [1], **arrays), travels),
        "box_intersection_volume": Call(_core.box_intersection_volume, boxes),
        "box_iou": Call(_core.box_iou, boxes),
        "closest_points": Call(lambda points: _core.closest_points(parts, [0, 1], points), {"points": clouds[0]}),
    }


def _sign(joints: Arrays) -> float:
    return float(np.sign(np.linalg.det(joints["directions"])))


CALLS = _calls()
ARGUMENTS = [(name, argument) for name, call in CALLS.items() for argument in call.arrays]
