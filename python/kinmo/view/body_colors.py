"""Colours of bodies: grey for what rests, a colour of its own for each body that moves."""

from __future__ import annotations

import colorsys
from collections.abc import Sequence

Color = tuple[float, float, float]
"""Red, green and blue in 0..1."""
RESTING: Color = (0.80, 0.80, 0.78)
MOVING: tuple[Color, ...] = (
    (0.30, 0.55, 0.85),
    (0.93, 0.60, 0.24),
    (0.36, 0.68, 0.42),
    (0.84, 0.37, 0.40),
    (0.60, 0.47, 0.78),
    (0.23, 0.70, 0.72),
    (0.90, 0.52, 0.72),
    (0.72, 0.68, 0.25),
)
"""Colours that also people with colour blindness can tell apart in this order."""


def body_colors(moving: Sequence[bool]) -> list[Color]:
    """One colour for each body. `moving` is True for each that moves. Colours repeat in lighter tones."""
    found: list[Color] = []
    count = 0
    for moves in moving:
        found.append(_moving_color(count) if moves else RESTING)
        count += moves
    return found


def _moving_color(place: int) -> Color:
    color = MOVING[place % len(MOVING)]
    hue, light, saturation = colorsys.rgb_to_hls(*color)
    turns = place // len(MOVING)
    return color if turns == 0 else colorsys.hls_to_rgb((hue + 0.06 * turns) % 1.0, min(0.85, light + 0.1 * turns), saturation)
