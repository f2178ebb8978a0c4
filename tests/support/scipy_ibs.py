"""The interaction region of `kinmo._core.interaction_regions`, by SciPy's Voronoi diagram of the whole scene.

An independent implementation of the same definition (Hu et al. 2015), vectorised, for tests and benches.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Voronoi

F64 = NDArray[np.float64]


@dataclass(frozen=True)
class ReferenceRegion:
    """Centroid [3] of the moving part's samples and the scores [A + B] of both parts' samples; `diagonal` of the scene."""

    centroid: F64
    scores: F64
    diagonal: float


def sphere(center: F64, radius: float) -> F64:
    """20 x 40 points by latitude and longitude, [800, 3]."""
    polar, azimuth = np.meshgrid(np.pi * (np.arange(20) + 0.5) / 20, 2 * np.pi * np.arange(40) / 40, indexing="ij")
    directions = np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=-1)
    return center + radius * directions.reshape(-1, 3)


def interaction_region(moving: F64, reference: F64) -> ReferenceRegion:
    """Scores every sample of `moving` [A, 3] and `reference` [B, 3] by the whole interaction bisector surface."""
    samples = np.concatenate([moving, reference]).astype(np.float64)
    low, high = samples.min(axis=0), samples.max(axis=0)
    diagonal = float(np.linalg.norm(high - low))
    diagram = Voronoi(np.concatenate([samples, sphere((low + high) / 2, diagonal * 2 / 3)]))

    sites = diagram.ridge_points
    lengths = np.fromiter(map(len, diagram.ridge_vertices), np.int64, len(sites))
    corners = np.fromiter((v for ridge in diagram.ridge_vertices for v in ridge), np.int64, lengths.sum())
    ridge_of = np.repeat(np.arange(len(sites)), lengths)
    bounded = np.ones(len(sites), bool)
    bounded[ridge_of[corners < 0]] = False
    of_parts = (sites < len(samples)).all(axis=1)
    between = (sites[:, 0] < len(moving)) != (sites[:, 1] < len(moving))
    wanted = (bounded & of_parts & between)[ridge_of]

    ridge_of, corners = ridge_of[wanted], corners[wanted]
    first = np.flatnonzero(np.diff(ridge_of, prepend=-1))
    counts = np.diff(np.append(first, len(ridge_of)))
    following = np.arange(1, len(corners) + 1)
    following[first + counts - 1] = first
    start = diagram.vertices[corners]
    end = start[following]
    mean = np.repeat(np.add.reduceat(start, first, axis=0) / counts[:, None], counts, axis=0)

    a, b = samples[sites[ridge_of, 0]], samples[sites[ridge_of, 1]]
    area = 0.5 * np.linalg.norm(np.cross(start - mean, end - mean), axis=1)
    to_sample = a - (start + end + mean) / 3
    distance = np.linalg.norm(to_sample, axis=1)
    normal = (a - b) / np.linalg.norm(a - b, axis=1, keepdims=True)
    alpha = np.arccos(np.clip((to_sample * normal).sum(axis=1) / distance, -1, 1))
    nearness = np.clip(1 - distance / (0.5 * diagonal), 0, None) ** 20
    weight = area * nearness * np.clip(1 - alpha / (np.pi / 3), 0, None)
    scores = np.bincount(sites[ridge_of].ravel(), weights=np.repeat(weight, 2), minlength=len(samples))
    own = scores[: len(moving)]
    return ReferenceRegion(own @ samples[: len(moving)] / own.sum(), scores, diagonal)
