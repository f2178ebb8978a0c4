"""3MF: the build items and their components are the parts, with z up and the unit of the file.

kinmo reads 3MF itself. trimesh loses the components above a mesh, and it invents names and makes repeated ones unique.
"""

from __future__ import annotations

import io
import zipfile
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

import numpy as np

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh, Shape
from kinmo.core.wording import clean_text
from kinmo.io.readers.reader import Reader
from kinmo.io.readers.scene import F64, Scene, SceneBuilder
from kinmo.io.readers.scene_shape import id_by_ending, shape_of_scene
from kinmo.io.readers.stated_facts import NO_FACTS, StatedFacts
from kinmo.io.readers.untrusted_files import MAX_SCENE_BYTES, read_bytes
from kinmo.io.readers.xml_files import check_plain_xml

THREEMF = "3mf"
_MODEL = "3D/3dmodel.model"
_METRES = {
    "micron": 1e-6, "millimeter": 0.001, "centimeter": 0.01, "meter": 1.0, "inch": 0.0254, "foot": 0.3048
}  # fmt: skip
_MATERIALS = ("base", "color", "texture2d")
"""Elements of materials, which are not read."""
_UNSHOWN = ("support", "solidsupport")
"""Types of objects that are no part of the model."""


@dataclass(eq=False)
class _Reference:
    """A use of an object: its place (file and id) and the transform [4, 4] to what uses it."""

    key: tuple[str, str]
    pose: F64
    name: str = ""


@dataclass(eq=False)
class _Object:
    """An object: a mesh, or components."""

    name: str
    is_shown: bool = True
    vertices: list[float] = field(default_factory=list)
    corners: list[int] = field(default_factory=list)
    components: list[_Reference] = field(default_factory=list)

    def mesh(self, path: Path) -> Mesh | None:
        if not self.corners:
            return None
        vertices, faces = np.array(self.vertices).reshape(-1, 3), np.array(self.corners).reshape(-1, 3)
        if faces.min() < 0 or faces.max() >= len(vertices):
            raise InputError(path, f"a triangle names a vertex outside 0..{len(vertices) - 1}")
        return Mesh(vertices, faces.astype(np.uint32))


def read_threemf(path: Path, facts: StatedFacts = NO_FACTS) -> Shape:
    """Read a 3MF file (see `shape_of_scene`)."""
    return shape_of_scene(read_threemf_scene(Path(path)), facts)


def read_threemf_scene(path: Path) -> Scene:
    """The scene of a 3MF file: a node for each build item, with a node below it for each component."""
    data = read_bytes(path, path.parent, MAX_SCENE_BYTES)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            package = _Package(path, archive)
            package.read_all()
    except InputError:
        raise
    except (zipfile.BadZipFile, OSError, RuntimeError, NotImplementedError, ValueError, EOFError) as error:
        raise InputError(path, f"expected a readable 3MF file ({error})") from None
    builder = SceneBuilder(path)
    for _ in range(package.materials):
        builder.ignore("materials")
    meshes: dict[tuple[str, str], Mesh | None] = {}
    pending = [(item, 0, np.eye(4)) for item in reversed(package.items)]
    while pending:
        use, parent, above = pending.pop()
        if use.key not in package.objects:
            raise InputError(path, f"object {clean_text(use.key[1])} is used, but not in the file")
        found = package.objects[use.key]
        if not found.is_shown:
            builder.ignore("supports")
            continue
        if use.key not in meshes:
            meshes[use.key] = found.mesh(path)
        pose = above @ use.pose
        place = builder.add(found.name or use.name, parent, meshes[use.key], pose)
        pending += [(component, place, pose) for component in reversed(found.components)]
    return builder.scene(THREEMF, "3MF", "z", package.metres_per_unit)


class _Package:
    """The objects and build items of a 3MF archive."""

    def __init__(self, path: Path, archive: zipfile.ZipFile) -> None:
        self.path = path
        self.archive = archive
        self.names = {name.lower().strip("/"): name for name in archive.namelist()}
        self.objects: dict[tuple[str, str], _Object] = {}
        self.items: list[_Reference] = []
        self.metres_per_unit = _METRES["millimeter"]
        self.materials = 0
        self._left = MAX_SCENE_BYTES
        self._object: _Object | None = None

    def read_all(self) -> None:
        """Read the root model, and the models that its objects are in."""
        models = [name for name in self.names if name.endswith(".model")]
        root = _MODEL.lower() if _MODEL.lower() in self.names else next(iter(models), "")
        if not root:
            raise InputError(self.path, f"expected {_MODEL} in the archive")
        done: set[str] = set()
        pending = [root]
        while pending:
            model = pending.pop()
            if model in done or model not in self.names:
                continue
            done.add(model)
            self._read(model, is_root=model == root)
            used = [each for found in self.objects.values() for each in found.components]
            pending += [use.key[0] for use in (*self.items, *used)]

    def _read(self, model: str, is_root: bool) -> None:
        info = self.archive.getinfo(self.names[model])
        self._left -= info.file_size
        if self._left < 0:
            raise InputError(self.path, f"unpacks to more than {MAX_SCENE_BYTES >> 20} MiB")
        text = self.archive.read(info)
        check_plain_xml(text, self.path)
        parser = expat.ParserCreate()

        def start(tag: str, attributes: dict[str, str]) -> None:
            name = tag.rpartition(":")[2] if ":" in tag else tag
            found = self._object
            if name == "vertex" and found is not None:  # first, because files have millions of these
                found.vertices += (float(attributes["x"]), float(attributes["y"]), float(attributes["z"]))
            elif name == "triangle" and found is not None:
                found.corners += (int(attributes["v1"]), int(attributes["v2"]), int(attributes["v3"]))
            else:
                self._start(name, attributes, model, is_root)

        parser.StartElementHandler = start
        try:
            parser.Parse(text, True)
        except InputError:
            raise
        except expat.ExpatError as error:
            raise InputError(self.path, f"{info.filename} is no XML ({error})") from None
        except KeyError as error:
            raise InputError(self.path, f"an element of {info.filename} has no attribute {error.args[0]}") from None
        except (ValueError, TypeError, OverflowError) as error:
            raise InputError(self.path, f"expected numbers in {info.filename} ({error})") from None

    def _start(self, tag: str, attributes: dict[str, str], model: str, is_root: bool) -> None:
        if tag == "object":
            is_shown = attributes.get("type", "model") not in _UNSHOWN
            self._object = self.objects[model, attributes["id"]] = _Object(attributes.get("name", ""), is_shown)
        elif tag == "component" and self._object is not None:
            self._object.components.append(_reference(attributes, model))
        elif tag in _MATERIALS:
            self.materials += 1
        elif tag == "item" and is_root:
            self.items.append(_reference(attributes, model))
        elif tag == "model" and is_root:
            unit = attributes.get("unit", "millimeter")
            if unit not in _METRES:
                raise InputError(self.path, f"expected one of {', '.join(_METRES)}, got {clean_text(unit)}", "unit")
            self.metres_per_unit = _METRES[unit]


def _reference(attributes: dict[str, str], model: str) -> _Reference:
    """A component or build item. The production extension names another file by `path`."""
    path = next((value for name, value in attributes.items() if name.rpartition(":")[2] == "path"), None)
    pose = np.eye(4)
    if "transform" in attributes:
        rows = np.array([float(number) for number in attributes["transform"].split()]).reshape(4, 3)
        pose[:3] = rows.T
    place = model if path is None else path.strip("/").lower()
    return _Reference((place, attributes["objectid"]), pose, attributes.get("partnumber", ""))


READER = Reader(
    THREEMF,
    read_threemf,
    lambda path: (path.absolute().parent, [path]),
    id_of_file=id_by_ending((".3mf",)),
    endings=(".3mf",),
    read_stated=read_threemf,
)
