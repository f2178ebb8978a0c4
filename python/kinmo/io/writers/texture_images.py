"""Image files of textures, each content once, in formats that the readers of a file understand."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from kinmo.core.look import Image, Material
from kinmo.core.names import unique_names
from kinmo.core.shape import Mesh

if TYPE_CHECKING:
    from PIL.Image import Image as Picture

MAX_PIXELS = 1 << 26
"""Largest image that is decoded: 8192 x 8192."""
PNG, JPEG = "image/png", "image/jpeg"
GLTF_TYPES = (PNG, JPEG)
"""Types of images that every reader of glTF knows."""
OBJ_TYPES = (PNG, JPEG, "image/bmp", "image/x-tga")
"""Types of images that readers of MTL files know."""
_ENDINGS = {PNG: "png", JPEG: "jpg", "image/bmp": "bmp", "image/x-tga": "tga"}
_FORMATS = ("PNG", "JPEG", "BMP", "TGA", "WEBP", "GIF")

Note = Callable[[str], None]
"""Receives one line about what a format cannot carry."""


def materials_of(meshes: Iterable[Mesh]) -> list[Material]:
    """The materials of some meshes, each once, in their order."""
    return list(dict.fromkeys(material for mesh in meshes if mesh.look is not None for material in mesh.look.materials))


@contextmanager
def decoded(image: Image) -> Iterator[Picture]:
    """The picture in an image, which may be of any mode.

    Args:
        image: The image.

    Raises:
        ValueError: It cannot be decoded, or is too large.
    """
    from PIL import Image as Pillow
    from PIL import UnidentifiedImageError

    try:
        with Pillow.open(io.BytesIO(image.data), formats=_FORMATS) as opened:
            if opened.width * opened.height > MAX_PIXELS:
                raise ValueError(f"{opened.width} x {opened.height} pixels are too many")
            opened.load()
            yield opened
    except UnidentifiedImageError:
        raise ValueError("its format is unknown") from None
    except Exception as error:  # Pillow raises many kinds of errors for broken images
        raise ValueError(str(error)) from None


def in_format(image: Image, types: tuple[str, ...], note: Note) -> Image | None:
    """The image itself if it has one of the types, else as PNG. None if it cannot be decoded, which is noted."""
    if image.mime in types:
        return image
    try:
        with decoded(image) as opened:
            has_palette = opened.mode not in ("L", "LA", "RGB", "RGBA")
            picture = opened.convert(
                "RGBA" if "transparency" in opened.info or opened.mode == "PA" else "RGB" if has_palette else None
            )
            file = io.BytesIO()
            picture.save(file, "PNG")
    except ValueError as error:
        note(f"image {image.name or 'without a name'} left out, as it cannot be converted to PNG ({error})")
        return None
    return Image(file.getvalue(), PNG, image.name)


class TextureImages:
    """Writes the images of some materials into a folder. The same materials give the same names.

    Args:
        folder: the folder. It is created for the first image.
        materials: all materials.
        note: what receives a line about an image that cannot be written.
    """

    def __init__(self, folder: Path, materials: Iterable[Material], note: Note) -> None:
        self._folder = folder
        self._note = note
        images: dict[bytes, str] = {}
        for material in materials:
            if material.image is not None:
                stem = Path(material.image.name.replace("\\", "/")).stem
                images.setdefault(material.image.data, stem or material.name or "texture")
        self._stems = dict(zip(images, unique_names(images.values()), strict=True))
        self._written: dict[tuple[bytes, tuple[str, ...]], str | None] = {}

    def file(self, image: Image, types: tuple[str, ...] = OBJ_TYPES) -> str | None:
        """Name of the file of an image, which is written the first time. None if it cannot be written.

        Args:
            image: the image of one of the materials.
            types: types that the file may have. An image of another type is converted to PNG.
        """
        key = image.data, types
        if key not in self._written:
            found = in_format(image, types, self._note)
            self._written[key] = None if found is None else f"{self._stems[image.data]}.{_ENDINGS[found.mime]}"
            if found is not None:
                self._folder.mkdir(parents=True, exist_ok=True)
                (self._folder / str(self._written[key])).write_bytes(found.data)
        return self._written[key]
