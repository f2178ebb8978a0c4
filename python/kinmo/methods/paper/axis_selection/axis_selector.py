"""Asking a trained axis-selection network."""

from __future__ import annotations

import zlib
from pathlib import Path
from weakref import WeakKeyDictionary

import numpy as np
import torch
from numpy.typing import NDArray

from kinmo.config import AxisConfig
from kinmo.core.typed_tables import from_table
from kinmo.features.candidate_joints import Candidates
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.weights import load_weights, pick_device
from kinmo.methods.paper.axis_selection.motion_clouds import displacements, marked_cloud, of_one_kind
from kinmo.methods.paper.axis_selection.siamese_network import KIND, AxisSelectionNetwork

CLOUDS_AT_ONCE = 64


class AxisSelector:
    """A trained network with its configuration."""

    def __init__(self, network: AxisSelectionNetwork, config: AxisConfig, device: str, sha256: str = "") -> None:
        self.network, self.config, self.device, self.sha256 = network.to(device).eval(), config, device, sha256
        self._known: WeakKeyDictionary[PreparedShape, dict[tuple[object, ...], NDArray[np.float64]]] = WeakKeyDictionary()

    @classmethod
    def load(cls, weights: Path, device: str = "auto") -> AxisSelector:
        """Read `weights.safetensors` of `train_axis_selection`. Raises InputError if they are not its, or not whole."""
        device = pick_device(device)
        loaded = load_weights(weights, KIND)
        config = from_table(AxisConfig, loaded.config, weights.with_suffix(".json"), "config.")
        network = AxisSelectionNetwork(config)
        loaded.fill(network)
        return cls(network, config, device, loaded.sha256)

    def score_candidates(self, shape: PreparedShape, moving: list[int], candidates: Candidates) -> NDArray[np.float64]:
        """s^f [C]: the mean feasibility in [0, 1] over the displacements, for the leaves at places `moving` (paper, section
        3.3).

        What parts that are neither movable nor reference are is not said; as in the release they are marked as the reference.
        The same shape and leaves give the same scores, and are looked at once for as long as the shape is in memory.
        """
        known = self._known.setdefault(shape, {})
        lines = candidates.kinds, candidates.directions, candidates.pivots
        asked = (tuple(sorted(moving)), *(values.tobytes() for values in lines))
        if asked not in known:
            known[asked] = self._scores(shape, moving, candidates)
        scores: NDArray[np.float64] = known[asked].copy()
        return scores

    @torch.inference_mode()
    def _scores(self, shape: PreparedShape, moving: list[int], candidates: Candidates) -> NDArray[np.float64]:
        scores = np.zeros(len(candidates))
        if not len(candidates):
            return scores
        rng = np.random.default_rng(zlib.crc32(f"{shape.geometry_hash} {sorted(moving)}".encode()))
        points, focus = self.config.encoder.points, self.config.focus
        cloud = marked_cloud(shape.leaf_points, shape.leaf_areas, moving, points, rng, focus=focus)
        original = self._features(cloud.shown()[None])
        for group in of_one_kind(candidates):
            angles, shifts = displacements(candidates.kinds[group])
            moved = cloud.moved(candidates.kinds[group], candidates.directions[group], candidates.pivots[group], angles, shifts)
            features = self._features(cloud.shown(moved.reshape(-1, *moved.shape[2:])))
            logits = self.network.compare(original.expand(len(features), -1), features)
            scores[group] = torch.sigmoid(logits).cpu().double().view(len(group), -1).mean(1).numpy()
        return scores

    def _features(self, clouds: NDArray[np.float32]) -> torch.Tensor:
        chunks = torch.split(torch.from_numpy(clouds), CLOUDS_AT_ONCE)
        return torch.cat([self.network.encoder(chunk.to(self.device)) for chunk in chunks])
