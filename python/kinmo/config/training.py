"""Configuration of optimisation: the same fields for every network."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Annotated, Literal

from kinmo.config.bounds import Amount, Count, NonNegative, Positive, Share
from kinmo.core.typed_tables import Within

Precision = Literal["32-true", "bf16-mixed", "16-mixed"]
"""Numbers that layers compute in: float32, or mixed with bfloat16 or float16."""


@dataclass(frozen=True)
class TrainingConfig:
    """Training with Adam."""

    epochs: Count
    """Number of epochs."""
    learning_rate: Annotated[float, Within(sys.float_info.min, 1e3)]
    """Learning rate of the first epoch."""
    weight_decay: Amount = 1e-4
    """Weight decay; above 0 it is decoupled (AdamW)."""
    decay: Positive = 0.7
    """Factor on the learning rate every `decay_epochs` epochs."""
    decay_epochs: NonNegative = 20
    """Epochs between two decays of the learning rate; 0 for a cosine schedule down to zero."""
    gradient_clip: Amount = 1.0
    """Largest norm of the gradient; 0 for no clipping."""
    average: Share = 0.0
    """Decay per step of a moving average of the weights, which is then validated and kept; 0 for no average."""
    keep: Literal["best", "last"] = "best"
    """Epoch that is kept: the best one on validation shapes, or the last one."""
    precision: Precision = "32-true"
    """Numbers that layers compute in: float32, or mixed with bfloat16 or float16."""
    threads: Annotated[int, Within(0, 1024)] = 0
    """CPU threads; 0 for PyTorch's choice. Small networks are fastest with one, and then equal on every machine."""
