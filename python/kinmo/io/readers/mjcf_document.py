"""The XML of an MJCF file (MuJoCo): included files, compiler settings, default classes and mesh assets."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from kinmo.core.errors import InputError
from kinmo.core.wording import clean_text
from kinmo.io.readers.robot_file import Matrix
from kinmo.io.readers.robot_numbers import read_list, read_numbers
from kinmo.io.readers.untrusted_files import named_by, plain_path, read_bytes
from kinmo.io.readers.xml_files import MAX_XML_BYTES, parse_xml

MAX_DEPTH = 64
"""Deepest nesting of elements, included files and default classes."""
_MAX_FILES = 100
"""Most files that are included."""
_MAIN = "main"
"""Name of the class that all other default classes inherit from."""

Attributes = dict[str, str]


class MjcfDocument:
    """An MJCF file with what it includes.

    Attributes:
        path: the file.
        home: a folder at or above that of the file. No path of the file may lead out of it.
        root: the element `<mujoco>`.
        included: the files that it includes, each as often as it does.
        uses_degrees: angles are in degrees, not in radians.
    """

    def __init__(self, path: Path, home: Path | None = None) -> None:
        self.path = path
        self.home = home or path.parent
        self.included: list[Path] = []
        self._bytes_left = MAX_XML_BYTES
        self.root = parse_xml(self._read(path), path)
        if self.root.tag != "mujoco":
            raise InputError(path, f"expected the element mujoco, found {clean_text(self.root.tag)}")
        self._include(self.root, 0, (plain_path(path),))
        settings: Attributes = {}
        for element in self.root.findall("compiler"):
            settings |= element.attrib
        self.uses_degrees = settings.get("angle", "degree") != "radian"
        if settings.get("coordinate", "local") != "local":
            raise InputError(path, "expected local coordinates: save the model with a newer MuJoCo", "compiler coordinate")
        self._euler = settings.get("eulerseq", "xyz")
        if len(self._euler) != 3 or not set(self._euler.lower()) <= set("xyz") or self._euler not in _cases(self._euler):
            raise InputError(path, f"expected an order of axes such as xyz, found {self._euler[:40]!r}", "compiler eulerseq")
        self.has_automatic_limits = settings.get("autolimits", "true") != "false"
        self._strips_paths = settings.get("strippath", "false") == "true"
        self._mesh_folder = settings.get("meshdir", settings.get("assetdir", ""))
        self._texture_folder = settings.get("texturedir", settings.get("assetdir", ""))
        self._defaults: dict[str, dict[str, Attributes]] = {_MAIN: {}}
        for element in self.root.findall("default"):
            self._read_defaults(element, _MAIN, 0)
            if element.get("class"):
                self._defaults[element.get("class", "")] = self._defaults[_MAIN]

    def with_defaults(self, element: ET.Element, inherited: str | None = None) -> Attributes:
        """The attributes of an element with those of its default class. `inherited` is the class of the bodies around it."""
        name = element.get("class") or inherited or _MAIN
        if name not in self._defaults:
            raise InputError(self.path, f"there is no default class {clean_text(name)}", clean_text(element.tag))
        return self._defaults[name].get(element.tag, {}) | element.attrib

    def assets(self, kind: str) -> Iterator[tuple[str, Attributes]]:
        """Name and attributes of each asset of a kind: mesh, material or texture."""
        for element in self.root.findall(f"asset/{kind}"):
            attributes = self.with_defaults(element)
            for layer in element.findall("layer"):  # of a material, which may have its image there
                if layer.get("role") in ("rgb", "rgba"):
                    attributes = attributes | {"texture": layer.get("texture", "")}
            yield attributes.get("name") or Path(attributes.get("file", "")).stem, attributes

    def mesh_path(self, name: str) -> Path:
        """The file of a mesh asset."""
        return self._asset_path(self._mesh_folder, name)

    def texture_path(self, name: str) -> Path:
        """The file of a texture asset."""
        return self._asset_path(self._texture_folder, name)

    def _asset_path(self, folder: str, name: str) -> Path:
        place = name.replace("\\", "/")
        return self.path.parent / folder / (Path(place).name if self._strips_paths else place)

    def angle(self, value: float) -> float:
        """An angle of the file in radians."""
        return float(np.radians(value)) if self.uses_degrees else value

    def pose(self, attributes: Attributes) -> Matrix:
        """Transform [4, 4] of a body, frame or geom to what it is in, from its position and orientation."""
        pose = np.eye(4)
        pose[:3, 3] = read_numbers(self.path, attributes, "pos", (0.0, 0.0, 0.0))
        pose[:3, :3] = self.orientation(attributes)
        return pose

    def orientation(self, attributes: Attributes) -> Matrix:
        """Rotation [3, 3] that the attributes quat, axisangle, euler, xyaxes or zaxis give."""
        if "quat" in attributes:
            w, x, y, z = read_list(self.path, attributes, "quat", 4, 4)
            if not 0.0 < float(np.linalg.norm([x, y, z, w])) < np.inf:
                raise InputError(self.path, "expected a quaternion that is not zero", "quat")
            return np.asarray(Rotation.from_quat([x, y, z, w]).as_matrix())
        if "axisangle" in attributes:
            *axis, angle = read_list(self.path, attributes, "axisangle", 4, 4)
            return np.asarray(Rotation.from_rotvec(self.angle(angle) * self.direction(axis, "axisangle")).as_matrix())
        if "euler" in attributes:
            angles = [self.angle(angle) for angle in read_list(self.path, attributes, "euler", 3, 3)]
            return np.asarray(Rotation.from_euler(self._euler.swapcase(), angles).as_matrix())  # SciPy's case is the opposite
        if "xyaxes" in attributes:
            numbers = read_list(self.path, attributes, "xyaxes", 6, 6)
            x = self.direction(numbers[:3], "xyaxes")
            y = self.direction(numbers[3:] - np.dot(numbers[3:], x) * x, "xyaxes")
            return np.stack([x, y, np.cross(x, y)], axis=1)
        if "zaxis" in attributes:
            return rotation_of_z(self.direction(read_list(self.path, attributes, "zaxis", 3, 3), "zaxis"))
        return np.eye(3)

    def direction(self, numbers: Matrix | list[float], field: str) -> Matrix:
        """A vector [3] of length 1."""
        vector = np.asarray(numbers, float)
        length = float(np.linalg.norm(vector))
        if not 1e-30 < length < np.inf:
            raise InputError(self.path, "expected a direction that is not zero", field)
        return vector / length

    def _read(self, path: Path) -> bytes:
        data = read_bytes(path, self.home, self._bytes_left)
        self._bytes_left -= len(data)
        return data

    def _include(self, element: ET.Element, depth: int, files: tuple[Path, ...]) -> None:
        """Replace all elements `<include>` at or below an element by the content of their files.

        `files` are the file with the element, and the files around it that include it, from the outside in.
        """
        if depth > MAX_DEPTH:
            raise InputError(self.path, f"nested deeper than {MAX_DEPTH} levels")
        place = 0
        while place < len(element):
            child = element[place]
            if child.tag != "include":
                self._include(child, depth + 1, files)
                place += 1
                continue
            if len(self.included) >= _MAX_FILES:
                raise InputError(self.path, f"includes more than {_MAX_FILES} files")
            name = child.get("file", "")
            file = plain_path(self.path.parent / name)
            if file in files:
                raise InputError(files[-1], f"{clean_text(name)} includes itself: remove this element", "include")
            try:
                data = self._read(file)
            except InputError as error:
                raise named_by(files[-1], "include", name, error) from None
            self.included.append(file)
            holder = ET.Element("include")
            holder.extend(parse_xml(data, file))
            self._include(holder, depth + 1, (*files, file))
            element[place : place + 1] = list(holder)
            place += len(holder)

    def _read_defaults(self, element: ET.Element, name: str, depth: int) -> None:
        """Add the settings of an element `<default>` to the class `name`, and the classes in it."""
        if depth > MAX_DEPTH:
            raise InputError(self.path, f"nested deeper than {MAX_DEPTH} levels", "default")
        own = self._defaults[name]
        for child in element:
            if child.tag != "default":
                own[child.tag] = own.get(child.tag, {}) | child.attrib
        for child in element.findall("default"):
            inner = child.get("class", "")
            if not inner:
                raise InputError(self.path, "expected a class in an inner element", "default")
            self._defaults[inner] = {tag: dict(attributes) for tag, attributes in own.items()}
            self._read_defaults(child, inner, depth + 1)


def rotation_of_z(direction: Matrix) -> Matrix:
    """The smallest rotation [3, 3] of the z axis to a unit vector [3]."""
    axis, cosine = np.cross([0.0, 0.0, 1.0], direction), float(direction[2])
    sine = float(np.linalg.norm(axis))
    if sine < 1e-12:
        return np.diag([1.0, np.sign(cosine), np.sign(cosine)])
    return np.asarray(Rotation.from_rotvec(axis / sine * np.arctan2(sine, cosine)).as_matrix())


def _cases(text: str) -> tuple[str, str]:
    return text.lower(), text.upper()
