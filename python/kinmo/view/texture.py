"""A texture that can be looked up at many places at once, without noise where it is seen from afar."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow

from kinmo.core.look import Image
from kinmo.io.writers.texture_images import decoded

F32 = NDArray[np.float32]

MAX_SIZE = 4096
"""Largest width and height in texels that is kept in memory."""


class Texture:
    """The pixels of an image, in full size and in halves of it.

    Args:
        image: The image.

    Raises:
        ValueError: The image cannot be decoded.

    Attributes:
        is_opaque: True if no pixel lets anything through.
    """

    def __init__(self, image: Image) -> None:
        with decoded(image) as opened:
            if opened.mode.startswith("I"):  # 16 bits, which Pillow would cut off at 255
                opened = Pillow.fromarray((np.asarray(opened, np.int64) >> 8).clip(0, 255).astype(np.uint8))
            picture = opened.convert("RGBA")
        step = -(-max(picture.size) // MAX_SIZE)
        picture = picture.reduce(step) if step > 1 else picture
        self._levels = [np.asarray(picture)]
        self.is_opaque = bool((self._levels[0][..., 3] == 255).all())
        while max(picture.size) > 1:
            picture = picture.reduce((min(2, picture.width), min(2, picture.height)))
            self._levels.append(np.asarray(picture))

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in texels."""
        height, width, _ = self._levels[0].shape
        return width, height

    def at(self, uvs: NDArray[np.float64], spread: NDArray[np.float64]) -> F32:
        """Red, green, blue and opacity [N, 4] in 0..1.

        Args:
            uvs: Texture coordinates [N, 2]. (0, 0) is the lower left of the image, which repeats.
            spread: Number of texels [N] between a place and its neighbours. What is smaller is averaged.
        """
        levels = np.log2(np.maximum(spread, 1.0)).round().astype(np.int64).clip(0, len(self._levels) - 1)
        found = np.empty((len(uvs), 4), np.float32)
        for level in np.flatnonzero(np.bincount(levels)).tolist():
            chosen = levels == level
            found[chosen] = _between(self._levels[level], uvs[chosen])
        return found


def _between(pixels: NDArray[np.uint8], uvs: NDArray[np.float64]) -> F32:
    """Values [N, 4] in 0..1 between the middles of pixels [height, width, 4]."""
    height, width, _ = pixels.shape
    places = (uvs - np.floor(uvs)) * [width, -height] + [-0.5, height - 0.5]
    corner = np.floor(places)
    right, down = np.moveaxis((places - corner).astype(np.float32), 1, 0)
    column, row = np.moveaxis(corner.astype(np.int64), 1, 0)
    found = np.zeros((len(uvs), 4), np.float32)
    for below, tall in ((0, 1.0 - down), (1, down)):
        for aside, wide in ((0, 1.0 - right), (1, right)):
            found += (tall * wide)[:, None] * pixels[(row + below) % height, (column + aside) % width]
    return np.asarray(found / np.float32(255.0))
