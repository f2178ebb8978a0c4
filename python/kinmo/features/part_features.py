"""Numbers that describe a part as a whole."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo.core.box import are_alike
from kinmo.features.scene import Scene, Unit


def unit_features(scene: Scene, unit: Unit, part_sizes: NDArray[np.float64]) -> NDArray[np.float64]:
    """All of `unit_numbers` in their order [G]."""
    return np.concatenate(list(unit_numbers(scene, unit, part_sizes).values()))


def unit_numbers(scene: Scene, unit: Unit, part_sizes: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    """Size, place, roundness, contact, protrusion and likes of a part, by name [g].

    Its likes are those of the parts of its shape, whose half extents are `part_sizes` [P, 3].
    """
    up, axes = scene.up, unit.sorted_axes
    half = np.sort(unit.minimum.half_extents)[::-1]
    low, high = scene.extents
    size = np.maximum(high - low, 1e-6)
    placed = unit.points @ scene.frame.T
    heights = (placed[:, 2] - low[2]) / size[2]
    sides = np.minimum(placed.min(axis=0) - low, high - placed.max(axis=0)) / size
    facing = np.abs(unit.normals @ axes.T)
    offset = unit.aligned.center - scene.middle
    contact = unit.contact_weights @ unit.contact - unit.aligned.center
    protrusion = unit.protrusion - unit.aligned.center
    alike = are_alike(half, part_sizes).sum()
    area = scene.areas[list(unit.leaves)].sum() / max(scene.areas.sum(), 1e-12)
    features = {
        "extents": np.log(half + 1e-3),
        "horizontal extents": np.log(np.sort(unit.aligned.half_extents[:2]) + 1e-3),
        "height": np.log(unit.aligned.half_extents[2] + 1e-3),
        "axes against up": np.abs(axes @ up),
        "area": np.log(area + 1e-4),
        "volume": np.log(unit.aligned.volume + 1e-7),
        "tilt": min(unit.minimum.volume / max(unit.aligned.volume, 1e-12), 1.5),
        "heights": np.quantile(heights, [0.0, 0.5, 1.0]),
        "distance from the middle": np.linalg.norm(offset - (offset @ up) * up),
        "margins to the sides": np.sort(sides[:2]),
        "margin to top or bottom": sides[2],
        "flat faces": (facing > 0.97).mean(axis=0),
        "round faces": (facing.max(axis=1) < 0.9).mean(),
        "distances to the rest": np.log(np.quantile(unit.distances, [0.0, 0.1, 0.5, 0.9, 1.0]) + 1e-3),
        "touching": [(unit.distances < near).mean() for near in (0.003, 0.01, 0.03, 0.08)],
        "contact": [contact @ up / unit.half_diagonal, np.linalg.norm(contact) / unit.half_diagonal],
        "contact against up": unit.mean_toward @ up,
        "contact is one-sided": np.linalg.norm(unit.mean_toward),
        "contact against axes": np.abs(axes @ unit.mean_toward),
        "protrusion": [np.linalg.norm(protrusion - contact) / unit.half_diagonal, protrusion @ up / unit.half_diagonal],
        "counts": np.log1p([alike, len(part_sizes), len(scene.areas), len(unit.leaves), len(unit.riders)]),
        "round pieces": np.log1p([len(unit.own_round), len(unit.next_round)]),
        "stands alone": float(not unit.rest),
        "object": np.log([*np.sort(size[:2]), size[2]]),
    }
    return {name: np.atleast_1d(np.asarray(value, float)) for name, value in features.items()}
