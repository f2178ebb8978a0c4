"""Prediction of joint limits by a trained limits network."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from kinmo.config import LimitsConfig
from kinmo.learning.weights import load_weights, pick_device
from kinmo.methods.kinmo.limits.limits_network import KIND, LimitsNetwork, likely_travel
from kinmo.methods.kinmo.limits.travel_examples import NO_WORD, TravelExamples


class LimitsPredictor:
    """A trained limits network. `hide_names` hides the names of parts and categories from it."""

    def __init__(self, network: LimitsNetwork, device: str, hide_names: bool) -> None:
        self.network, self.device, self.hide_names = network.to(device).eval(), device, hide_names

    @classmethod
    def load(cls, weights: Path, device: str = "auto", hide_names: bool = False) -> LimitsPredictor:
        """Read weights that `train_joint_limits` wrote.

        Raises:
            InputError: The weights are those of another network, or cut off.
        """
        device = pick_device(device)
        loaded = load_weights(weights, KIND)
        directed, shared = loaded.sizes("directed_features", "shared_features")
        network = LimitsNetwork(directed, shared, loaded.typed_config(LimitsConfig))
        loaded.fill(network)
        return cls(network, device, hide_names)

    @torch.inference_mode()
    def travel(self, joints: TravelExamples) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Travel [J, 2] along the direction of each joint and against it, in its scales, and whether [J] it has limits."""
        words = np.full_like(joints.words, NO_WORD) if self.hide_names else joints.words
        inputs = (torch.from_numpy(values).to(self.device) for values in (joints.directed, joints.shared, words))
        travel, is_limited = self.network(*inputs)
        return likely_travel(travel.exp().cpu().double().numpy()), (is_limited > 0).cpu().numpy()
