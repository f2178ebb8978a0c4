"""Siamese network that predicts the feasibility of a motion from the clouds before and after it (paper, section 3.3)."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from kinmo.config import AxisConfig
from kinmo.learning.network_layers import channel_norm, point_encoder

KIND = "axis_selection"
"""Kind of the network in files of weights (`kinmo.learning.weights`)."""
CHANNELS = 4
"""Input channels: x, y, z, and a label that is 1 on the moving part and 0 elsewhere."""


class AxisSelectionNetwork(nn.Module):
    """One point encoder for both clouds, and fully connected layers on the two features."""

    def __init__(self, config: AxisConfig) -> None:
        super().__init__()
        self.encoder = point_encoder(config.encoder, CHANNELS)
        layers: list[nn.Module] = []
        width = 2 * self.encoder.features
        for after in config.head:
            norm = channel_norm(config.encoder.norm, after)
            layers += [nn.Linear(width, after, bias=False), norm, nn.ReLU(), nn.Dropout(config.head_dropout)]
            width = after
        layers.append(nn.Linear(width, 1))
        self.head = nn.Sequential(*layers)

    def compare(self, original: Tensor, moved: Tensor) -> Tensor:
        """Logits [B] of feasibility from two features [B, F] of the encoder."""
        return self.head(torch.cat([original, moved], 1)).squeeze(1)  # type: ignore[no-any-return]

    def forward(self, original: Tensor, *moved: Tensor) -> Tensor:
        """Logits of feasibility [K * B], from clouds [B, n, 4] before a motion and after K motions."""
        first, *others = self.encoder(torch.cat([original, *moved])).chunk(1 + len(moved))
        return self.compare(first.repeat(len(moved), 1), torch.cat(others))
