"""Images that 3D files name. They stay encoded: only their first bytes are looked at."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.core.look import Image
from kinmo.core.wording import clean_text
from kinmo.io.readers.untrusted_files import read_bytes

MAX_IMAGE_BYTES = 128 << 20
"""Largest encoded image."""
MAX_ALL_BYTES = 512 << 20
"""Most bytes of all images of an object together."""
MAX_NAMED = 5
"""Most images that cannot be read and are reported by name."""
_MAGIC = ((b"\x89PNG\r\n\x1a\n", "image/png"), (b"\xff\xd8\xff", "image/jpeg"), (b"BM", "image/bmp"), (b"GIF8", "image/gif"))

Ignore = Callable[[str], None]
"""Receives what is not read, such as "normal maps"."""


class ImageBudget:
    """Makes images of encoded bytes, until they are too many."""

    def __init__(self, ignore: Ignore) -> None:
        self._ignore = ignore
        self._left = MAX_ALL_BYTES

    def image(self, data: bytes | memoryview, name: str) -> Image | None:
        """An image, or None if its format is unknown, or it is too large, which is reported."""
        mime = image_type(bytes(data[:16]), name)
        if mime is None:
            self._ignore("images of a format other than PNG, JPEG, WebP, BMP, TGA and GIF")
        elif len(data) > min(MAX_IMAGE_BYTES, self._left):
            self._ignore("images that are too large")
        else:
            self._left -= len(data)
            return Image(bytes(data), mime, clean_text(name))
        return None


def image_type(begin: bytes, name: str) -> str | None:
    """Type of an image by its first 16 bytes, or by its name for TGA, which has no mark. None if it is unknown."""
    if begin[:4] == b"RIFF" and begin[8:12] == b"WEBP":
        return "image/webp"
    known = next((mime for magic, mime in _MAGIC if begin.startswith(magic)), None)
    return "image/x-tga" if known is None and name.lower().endswith(".tga") else known


class ImageFiles:
    """Reads the image files of one object, each once.

    Args:
        folder: the folder that no path may lead out of.
        ignore: what receives the problem of an image that cannot be read.
    """

    def __init__(self, folder: Path, ignore: Ignore) -> None:
        self._folder = folder
        self._ignore = ignore
        self._budget = ImageBudget(ignore)
        self._images: dict[Path, Image | None] = {}
        self._failed = 0

    @property
    def paths(self) -> list[Path]:
        """The files that were asked for."""
        return list(self._images)

    def read(self, path: Path) -> Image | None:
        """The image in a file. None if it cannot be used, which is reported."""
        if path not in self._images:
            self._images[path] = None
            try:
                data = read_bytes(path, self._folder, MAX_IMAGE_BYTES)
            except InputError as error:
                self._failed += 1
                named = f"image {clean_text(path.name)} ({error.problem})"
                self._ignore(named if self._failed <= MAX_NAMED else "further images that cannot be read")
            else:
                self._images[path] = self._budget.image(data, path.name)
        return self._images[path]
