"""Bounded types of configuration fields."""

from __future__ import annotations

import sys
from typing import Annotated

from kinmo.core.typed_tables import Within

MAX_COUNT = 10**9
Count = Annotated[int, Within(1, MAX_COUNT)]
NonNegative = Annotated[int, Within(0, MAX_COUNT)]
Positive = Annotated[float, Within(sys.float_info.min, sys.float_info.max)]
Amount = Annotated[float, Within(0.0, sys.float_info.max)]
Share = Annotated[float, Within(0.0, 1.0)]
Offset = Annotated[float, Within(-100.0, 100.0)]
Counts = Annotated[tuple[Count, ...], Within(1)]
