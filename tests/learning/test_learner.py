"""The learning rate of a learner: one cycle."""

from __future__ import annotations

import pytest
import torch

from kinmo.learning.learner import one_cycle


@pytest.mark.parametrize("steps", [*range(2, 30), 1000])
def test_a_cycle_of_several_steps_rises_and_falls(steps: int) -> None:
    optimizer = torch.optim.SGD([torch.zeros(1, requires_grad=True)], lr=1.0)
    schedule = one_cycle(optimizer, 0.5, steps)
    rates = [schedule.get_last_lr()[0]]
    for _ in range(steps):
        optimizer.step()
        schedule.step()
        rates.append(schedule.get_last_lr()[0])
    top = rates.index(max(rates))
    assert 0.4 < max(rates) <= 0.5 and rates[-1] < max(rates)
    assert rates[: top + 1] == sorted(rates[: top + 1]) and rates[top:] == sorted(rates[top:], reverse=True)
