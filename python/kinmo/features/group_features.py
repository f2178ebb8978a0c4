"""Features that describe a group of leaves as a whole."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo.core.oriented_box import have_similar_size
from kinmo.features.group_geometry import GroupGeometry
from kinmo.features.shape_geometry import ShapeGeometry


def named_group_features(
    shape: ShapeGeometry, group: GroupGeometry, part_sizes: NDArray[np.float64]
) -> dict[str, NDArray[np.float64]]:
    """Size, position, flatness, roundness, contact, protrusion and repetition of a group.

    Args:
        shape: The shape that the group belongs to.
        group: The group.
        part_sizes ([P, 3]): Half extents of the parts that the group is compared with and counted among.

    Returns:
        Arrays [g] by name; concatenated in their order they are the group's features [G].
    """
    up, axes = shape.up, group.sorted_axes
    half = np.sort(group.minimum.half_extents)[::-1]
    low, high = shape.extents
    size = np.maximum(high - low, 1e-6)
    placed = group.points @ shape.frame.T
    heights = (placed[:, 2] - low[2]) / size[2]
    margins = np.minimum(placed.min(axis=0) - low, high - placed.max(axis=0)) / size
    axis_cosines = np.abs(group.normals @ axes.T)
    offset = group.aligned.center - shape.middle
    contact = group.contact_weights @ group.contact - group.aligned.center
    protrusion = group.protrusion - group.aligned.center
    alike = have_similar_size(half, part_sizes).sum()
    area = shape.areas[list(group.leaves)].sum() / max(shape.areas.sum(), 1e-12)
    features = {
        "extents": np.log(half + 1e-3),
        "horizontal extents": np.log(np.sort(group.aligned.half_extents[:2]) + 1e-3),
        "height": np.log(group.aligned.half_extents[2] + 1e-3),
        "axes against up": np.abs(axes @ up),
        "area": np.log(area + 1e-4),
        "volume": np.log(group.aligned.volume + 1e-7),
        "tilt": min(group.minimum.volume / max(group.aligned.volume, 1e-12), 1.5),
        "heights": np.quantile(heights, [0.0, 0.5, 1.0]),
        "distance from the middle": np.linalg.norm(offset - (offset @ up) * up),
        "margins to the sides": np.sort(margins[:2]),
        "margin to top or bottom": margins[2],
        "flat faces": (axis_cosines > 0.97).mean(axis=0),
        "round faces": (axis_cosines.max(axis=1) < 0.9).mean(),
        "distances to the rest": np.log(np.quantile(group.distances, [0.0, 0.1, 0.5, 0.9, 1.0]) + 1e-3),
        "share in contact": [(group.distances < near).mean() for near in (0.003, 0.01, 0.03, 0.08)],
        "contact": [contact @ up / group.half_diagonal, np.linalg.norm(contact) / group.half_diagonal],
        "contact against up": group.mean_toward @ up,
        "one-sided contact": np.linalg.norm(group.mean_toward),
        "contact against axes": np.abs(axes @ group.mean_toward),
        "protrusion": [np.linalg.norm(protrusion - contact) / group.half_diagonal, protrusion @ up / group.half_diagonal],
        "counts": np.log1p([alike, len(part_sizes), len(shape.areas), len(group.leaves), len(group.riders)]),
        "round pieces": np.log1p([len(group.own_round), len(group.neighbour_round)]),
        "stands alone": float(not group.rest),
        "object size": np.log([*np.sort(size[:2]), size[2]]),
    }
    return {name: np.atleast_1d(np.asarray(value, float)) for name, value in features.items()}
