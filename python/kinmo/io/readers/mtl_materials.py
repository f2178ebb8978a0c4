"""Materials of OBJ files: MTL files and the images that they name."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.core.look import Image, Material
from kinmo.core.wording import clean_text
from kinmo.io.readers.image_files import MAX_NAMED, Ignore, ImageFiles
from kinmo.io.readers.untrusted_files import read_bytes

MAX_MTL_BYTES = 16 << 20
BRIGHTEST = 1000.0
"""Specular exponent `Ns` of a mirror, as Blender has it."""
_UNUSED_MAPS = {
    "map_bump": "normal maps", "bump": "normal maps", "norm": "normal maps", "map_kn": "normal maps",
    "disp": "displacement maps",
    "map_d": "opacity maps", "map_ke": "emission maps", "map_ks": "specular maps", "map_ns": "specular maps",
    "map_pr": "maps of metalness and roughness", "map_pm": "maps of metalness and roughness", "refl": "reflection maps",
}  # fmt: skip
_OPTION_SIZES = {
    "-blendu": 1, "-blendv": 1, "-boost": 1, "-mm": 2, "-o": 3, "-s": 3, "-t": 3, "-texres": 1, "-clamp": 1, "-bm": 1,
    "-imfchan": 1, "-type": 1, "-cc": 1, "-colorspace": 1,
}  # fmt: skip
"""Number of words after each option of a texture."""


class MtlMaterials:
    """Reads the materials of the OBJ files of one object, each file once.

    Args:
        folder: the folder that no path may lead out of.
        ignore: what receives a line about everything that is not read.
        reads_files: False to read no MTL file, for files whose format has materials of its own.
    """

    def __init__(self, folder: Path, ignore: Ignore, *, reads_files: bool = True) -> None:
        self.ignore = ignore
        self._reads_files = reads_files
        self._folder = folder
        self._images = ImageFiles(folder, ignore)
        self._files: dict[Path, dict[str, Material]] = {}
        self._failed = 0

    def of(self, obj: Path, libraries: Iterable[str]) -> dict[str, Material]:
        """The materials by name in the libraries that the file `obj` names in its lines `mtllib`."""
        found: dict[str, Material] = {}
        for line in libraries if self._reads_files else ():
            names = [line] if _is_file(obj.parent / line.replace("\\", "/")) else line.split()
            for name in names:
                found |= self._file(obj.parent / name.replace("\\", "/"))
        return found

    def image(self, path: Path) -> Image | None:
        """The image in a file. None if it cannot be used, which is reported."""
        return self._images.read(path)

    def _file(self, path: Path) -> dict[str, Material]:
        if path not in self._files:
            self._files[path] = {}
            try:
                text = read_bytes(path, self._folder, MAX_MTL_BYTES).decode("utf-8", "replace")
            except InputError as error:
                self._failed += 1
                named = f"materials {clean_text(path.name)} ({error.problem})"
                self.ignore(named if self._failed <= MAX_NAMED else "further material files that cannot be read")
            else:
                self._files[path] = self._parse(text, path)
        return self._files[path]

    def _parse(self, text: str, path: Path) -> dict[str, Material]:
        found: dict[str, Material] = {}
        values: dict[str, str] = {}
        name: str | None = None
        for line in [*text.replace("\\\n", " ").splitlines(), "newmtl"]:
            key, _, rest = line.strip().replace("\t", " ").partition(" ")
            if key == "newmtl":
                if name is not None:
                    found[name] = self._material(name, values, path)
                name, values = rest.strip(), {}
            elif key and not key.startswith("#"):
                values.setdefault(key.lower(), rest.partition(" #")[0].strip())
        return found

    def _material(self, name: str, values: dict[str, str], path: Path) -> Material:
        color, emitted = _color(values.get("kd"), 1.0), _color(values.get("ke"), 0.0)
        opacity = _number(values.get("d"), 1.0 - _number(values.get("tr"), 0.0))
        image = self._image(values["map_kd"], path) if "map_kd" in values else None
        if image is not None and color == (0.0, 0.0, 0.0):
            color = (1.0, 1.0, 1.0)  # some tools write black beside a texture, and mean the texture
        is_masked = "map_d" in values and values["map_d"] == values.get("map_kd")
        for key, what in _UNUSED_MAPS.items():
            if key in values and not (key == "map_d" and is_masked):
                self.ignore(what)
        shine = _number(values.get("ns"), 0.0, BRIGHTEST)
        return Material(
            clean_text(name),
            (*color, opacity),
            image,
            _number(values.get("pm"), 0.0),
            _number(values.get("pr"), 1.0 - math.sqrt(shine / BRIGHTEST)),
            emitted,
            alpha_mode="BLEND" if opacity < 1.0 or is_masked else "OPAQUE",
        )

    def _image(self, text: str, path: Path) -> Image | None:
        """The image of a texture, without its options."""
        words = text.split()
        count = 0
        while count < len(words) and words[count] in _OPTION_SIZES:
            option = words[count]
            count += 1
            for _ in range(_OPTION_SIZES[option]):
                if count < len(words) - 1 and (option not in ("-o", "-s", "-t") or _is_number(words[count])):
                    count += 1
        name = text if count == 0 else " ".join(words[count:])
        if count:
            self.ignore("options of textures")
        if not name:
            return None
        place = path.parent / name.replace("\\", "/")
        beside = path.parent / place.name
        if not _is_file(place) and _is_file(beside):  # many files name a path of their maker's machine
            place = beside
        return self._images.read(place)

    @property
    def paths(self) -> list[Path]:
        """The MTL files and images that were asked for."""
        return [*self._files, *self._images.paths]


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def _number(text: str | None, default: float, most: float = 1.0) -> float:
    """A number from 0 to `most`, or the default if there is none."""
    words = (text or "").split()
    return min(max(float(words[0]), 0.0), most) if words and _is_number(words[0]) else default


def _color(text: str | None, default: float) -> tuple[float, float, float]:
    """Red, green and blue from 0 to 1. One number stands for all three."""
    words = (text or "").split()[:3]
    if not words or not all(map(_is_number, words)):
        return default, default, default
    red, green, blue = [_number(word, default) for word in (words if len(words) == 3 else words[:1] * 3)]
    return red, green, blue
