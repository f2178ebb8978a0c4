"""An exponential moving average of a network's weights: steadier than the last step's, and better on unseen shapes."""

from __future__ import annotations

from collections.abc import Sequence

from torch import Tensor, nn
from torch.optim.swa_utils import AveragedModel, get_ema_multi_avg_fn

WARM_UP_STEPS = 10
"""The average forgets its first steps faster: at step t the decay is at most (1 + t) / (WARM_UP_STEPS + t)."""


def moving_average(module: nn.Module, decay: float) -> AveragedModel:
    """Copy of a module whose weights follow the module's by an exponential moving average.

    Call `update_parameters(module)` after every optimizer step. Floating-point buffers, such as the statistics of batch norms,
    are averaged like parameters; other buffers are copied.

    Args:
        module: The module to be trained.
        decay: Share of the previous average that remains after a step, in [0, 1).

    Returns:
        The average. Its `module` attribute is the averaged copy, of the same class as `module`.
    """

    def update(averages: Sequence[Tensor], current: Sequence[Tensor], steps: Tensor | int) -> None:
        if averages[0].is_floating_point():
            share = min(decay, (1.0 + float(steps)) / (WARM_UP_STEPS + float(steps)))
            get_ema_multi_avg_fn(share)(averages, current, steps)  # type: ignore[no-untyped-call]
        else:
            for own, other in zip(averages, current, strict=True):
                own.copy_(other)

    return AveragedModel(module, multi_avg_fn=update, use_buffers=True)
