"""Figures of joint limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinmo.core.joint import Joint, JointKind
from limits import figures

TRUE = Joint(JointKind.PRISMATIC, np.array([1.0, 0.0, 0.0]), np.zeros(3), 0.0, 1.0)


@pytest.mark.parametrize(
    ("lower", "upper", "overlap", "side"),
    [(0.0, 1.0, 1.0, 1.0), (0.0, 0.5, 0.5, 1.0), (-1.0, 0.0, 0.0, 0.0), (-1.0, 1.0, 0.5, 0.0), (None, None, 0.0, 0.0)],
)
def test_a_range_has_an_overlap_and_a_side_in_either_direction(lower, upper, overlap, side):
    found = replace(TRUE, lower=lower, upper=upper)
    for true, other in ((TRUE, found), (TRUE, found.reversed()), (TRUE.reversed(), found)):
        assert figures([(true, other)]) == pytest.approx((overlap, side))
