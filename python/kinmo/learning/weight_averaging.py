"""The mean of a network's recent weights: steadier than the last step's, and better on shapes never seen."""

from __future__ import annotations

from lightning.pytorch.callbacks import WeightAveraging
from torch import Tensor
from torch.optim.swa_utils import get_ema_multi_avg_fn

WARM_UP = 10
"""Early steps are averaged over fewer of them, so that the start is soon forgotten."""


class ExponentialAverage(WeightAveraging):
    """Keeps an exponential moving average of the weights; validation sees the average, training goes on without it."""

    def __init__(self, decay: float) -> None:
        def average(kept: list[Tensor], current: list[Tensor], steps: Tensor | int) -> None:
            if kept[0].is_floating_point():
                share = min(decay, (1.0 + float(steps)) / (WARM_UP + float(steps)))
                get_ema_multi_avg_fn(share)(kept, current, steps)  # type: ignore[no-untyped-call]
                return
            for own, other in zip(kept, current, strict=True):
                own.copy_(other)

        super().__init__(multi_avg_fn=average)

    def weights(self) -> dict[str, Tensor]:
        """The averaged state of the module that is trained. Raises RuntimeError before the training."""
        if self._average_model is None:
            raise RuntimeError("nothing has been averaged yet")
        weights: dict[str, Tensor] = self._average_model.module.state_dict()
        return weights
