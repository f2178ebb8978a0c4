"""Prediction of feasibility scores by a trained axis selection network (paper, section 3.3)."""

from __future__ import annotations

import zlib
from pathlib import Path
from weakref import WeakKeyDictionary

import numpy as np
import torch
from numpy.typing import NDArray

from kinmo.config import AxisConfig
from kinmo.core.joint import KINDS
from kinmo.features.candidate_joints import CandidateJoints
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.weights import load_weights, pick_device
from kinmo.methods.paper.axis_selection.siamese_network import KIND, AxisSelectionNetwork
from kinmo.methods.paper.axis_selection.transformed_clouds import TEST_DISPLACEMENTS, angles_and_shifts, labelled_cloud

CLOUDS_PER_BATCH = 64
"""Number of clouds that the encoder gets at a time."""


class AxisSelector:
    """A trained axis selection network with its configuration."""

    def __init__(self, network: AxisSelectionNetwork, config: AxisConfig, device: str) -> None:
        self.network, self.config, self.device = network.to(device).eval(), config, device
        self._known: WeakKeyDictionary[PreparedShape, dict[tuple[object, ...], NDArray[np.float64]]] = WeakKeyDictionary()

    @classmethod
    def load(cls, weights: Path, device: str = "auto") -> AxisSelector:
        """Read weights that `train_axis_selection` wrote.

        Raises:
            InputError: The weights are those of another network, or cut off.
        """
        device = pick_device(device)
        loaded = load_weights(weights, KIND)
        config = loaded.typed_config(AxisConfig)
        network = AxisSelectionNetwork(config)
        loaded.fill(network)
        return cls(network, config, device)

    def feasibility(self, shape: PreparedShape, moving: list[int], candidates: CandidateJoints) -> NDArray[np.float64]:
        """Feasibility scores s^f [C] in [0, 1]: mean predicted feasibility over the test displacements (paper, section 3.3).

        The paper does not say how parts are labelled that are neither movable nor reference. As in the release they get the
        label of the reference. `moving` are the positions of the leaves that move. Scores are kept as long as the shape is in
        memory.
        """
        known = self._known.setdefault(shape, {})
        lines = candidates.kinds, candidates.directions, candidates.pivots
        key = (tuple(sorted(moving)), *(values.tobytes() for values in lines))
        if key not in known:
            known[key] = self._scores(shape, moving, candidates)
        return known[key]

    @torch.inference_mode()
    def _scores(self, shape: PreparedShape, moving: list[int], candidates: CandidateJoints) -> NDArray[np.float64]:
        scores = np.zeros(len(candidates))
        if not len(candidates):
            return scores
        rng = np.random.default_rng(zlib.crc32(f"{shape.geometry_hash} {sorted(moving)}".encode()))
        points, focus = self.config.encoder.points, self.config.focus
        cloud = labelled_cloud(shape.leaf_points, shape.leaf_areas, moving, points, rng, focus=focus)
        original = self._features(cloud.network_input()[None])
        for code in np.unique(candidates.kinds):
            kind, rows = KINDS[code], np.flatnonzero(candidates.kinds == code)
            motions = angles_and_shifts(kind, np.tile(TEST_DISPLACEMENTS[kind], (len(rows), 1)))
            some = candidates.subset(rows)
            moved = cloud.transformed(some.kinds, some.directions, some.pivots, *motions)
            features = self._features(cloud.network_input(moved.reshape(-1, *moved.shape[2:])))
            logits = self.network.compare(original.expand(len(features), -1), features)
            scores[rows] = torch.sigmoid(logits).cpu().double().view(len(rows), -1).mean(1).numpy()
        return scores

    def _features(self, clouds: NDArray[np.float32]) -> torch.Tensor:
        chunks = torch.split(torch.from_numpy(clouds), CLOUDS_PER_BATCH)
        return torch.cat([self.network.encoder(chunk.to(self.device)) for chunk in chunks])
