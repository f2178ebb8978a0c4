"""The mesh files that a robot file names."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh, join
from kinmo.core.wording import printable_path
from kinmo.io.readers.dae_reader import READER as DAE_READER
from kinmo.io.readers.dae_reader import read_dae_scene
from kinmo.io.readers.gltf_reader import READER as GLB_READER
from kinmo.io.readers.gltf_reader import read_glb_scene
from kinmo.io.readers.msh_mesh import read_msh_mesh
from kinmo.io.readers.mtl_materials import MtlMaterials
from kinmo.io.readers.obj_reader import read_obj
from kinmo.io.readers.off_mesh import read_off_mesh
from kinmo.io.readers.ply_mesh import read_ply_mesh
from kinmo.io.readers.scene import CornerBudget, Scene
from kinmo.io.readers.stl_reader import read_stl_scene
from kinmo.io.readers.untrusted_files import MAX_MESH_BYTES, inside, plain_path, read_bytes

_READERS = {ending: reader for reader in (DAE_READER, GLB_READER) for ending in reader.endings}
"""Readers of mesh formats whose files may name further files, by ending."""


def refuse(problem: InputError) -> None:
    """Raise a problem: for callers that accept no missing mesh."""
    raise problem


def is_file(path: Path) -> bool:
    """True if the file exists. False for a name that no file can have."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def mesh_path(name: str, robot: Path, home: Path) -> Path:
    """The file that a URDF or SDF file means by the name of a mesh.

    Args:
        name: the name as it is written.
        robot: the robot file. Packages and models are searched beside it and in the folders above it, up to `home`: first in
            the nearest folder of the name of the package.
        home: a folder at or above that of the file.
    """
    package, tail = package_parts(name)
    if not package:
        return robot.parent / name.removeprefix("file://")
    folders = _searched(robot, home)
    places = [folder / tail for folder in folders if folder.name == package][:1]
    places += [folder / each for folder in folders for each in (f"{package}/{tail}", tail)]
    return next((place for place in places if is_file(place)), places[0])


def package_parts(name: str) -> tuple[str, str]:
    """The package or model in the name of a mesh, and the path in it. The package is empty for a path without one."""
    scheme, _, path = name.partition("://")
    package, _, tail = path.partition("/")
    return (package, tail) if scheme in ("package", "model") else ("", name)


def missing_mesh(name: str, robot: Path, home: Path) -> str:
    """A message about a mesh that `mesh_path` does not find. The arguments are the same."""
    package, _ = package_parts(name)
    if not package:
        return "expected a mesh file, found none"
    nearest, *others = (printable_path(folder) for folder in _searched(robot, home))
    places = f"{nearest} and above it up to {others[-1]}" if others else nearest
    named = any(folder.name == package for folder in _searched(robot, home))
    remedy = "" if named else f": the folder of {robot.name}, or one above it, must have the name {package}"
    return f"{name} is missing, looked in {places}{remedy}"


def _searched(robot: Path, home: Path) -> list[Path]:
    """The folder of a robot file, and those above it up to `home`."""
    first, top = plain_path(robot).parent, plain_path(home)
    return [first, *(folder for folder in first.parents if folder.is_relative_to(top))]


def with_their_files(meshes: Iterable[Path]) -> list[Path]:
    """Mesh files, each with the files that it names, such as the buffers and images of glTF. Those of OBJ are left out."""
    found: list[Path] = []
    for mesh in meshes:
        reader = _READERS.get(mesh.suffix.lower())
        found += [mesh] if reader is None or not is_file(mesh) else reader.source_files(mesh)[1]
    return found


class RobotMeshes:
    """Reads the mesh files of one robot, each once.

    Attributes:
        home: the folder that no path may lead out of.
        files: all files that were asked for.
    """

    def __init__(
        self, path: Path, home: Path, report: Callable[[InputError], None], materials: MtlMaterials | None = None
    ) -> None:
        """Args: the robot file, `home`, what receives the problem of an unreadable mesh, and the materials of meshes."""
        self.home = home
        self._path = path
        self.files: list[Path] = []
        self._budget = CornerBudget(path)
        self._report = report
        self._materials = materials
        self._meshes: dict[Path, Mesh | None] = {}

    def read(self, path: Path, missing: Callable[[], str] | None = None) -> Mesh | None:
        """The triangles of a mesh file in its own frame. None if it cannot be read, which is reported once.

        Args:
            path: the mesh file.
            missing: gives what to report if there is no such file. None for the usual words.

        Raises:
            InputError: the path leads out of `home`.
        """
        file = self._inside(path)
        if file not in self._meshes:
            self.files.append(file)
            self._meshes[file] = None
            try:
                if missing is not None and not is_file(file):
                    raise InputError(file, missing())
                self._meshes[file] = read_mesh(file, self._materials)
            except InputError as problem:
                self._report(problem)
        mesh = self._meshes[file]
        return None if mesh is None else self.counted(mesh)

    def _inside(self, path: Path) -> Path:
        """The path as `inside` gives it. A missing file, maybe of another machine, is named as such."""
        try:
            return inside(path, self.home)
        except InputError as error:
            if is_file(path):
                is_near = self._path.suffix.lower() == ".urdf" and self.home.parent in plain_path(path).parents
                remedy = f": put an empty package.xml into {printable_path(self.home.parent)} to allow it" if is_near else ""
                raise InputError(self._path, f"{printable_path(path)}: {error.problem}{remedy}", "mesh") from None
            problem = f"is missing, and leads out of the folder {self.home.name}: write its path relative to {self._path.name}"
            raise InputError(self._path, f"the mesh {printable_path(path)} {problem}") from None

    def counted(self, mesh: Mesh) -> Mesh:
        """The mesh itself. Raises InputError if the meshes of the robot have too many corners together."""
        self._budget.spend(len(mesh.vertices) + mesh.faces.size)
        return mesh


def read_mesh(path: Path, materials: MtlMaterials | None = None) -> Mesh:
    """All triangles of a mesh file (OBJ, STL, PLY, OFF, MSH, DAE, glTF) in the frame of the file.

    Coordinates of DAE files are in metres, whatever their unit. Their up axis is ignored, as in ROS. Raises InputError for
    files that are missing or broken, have no faces, or have another format. OBJ files have their look if `materials` is given,
    which also receives what is not read of other files.
    """
    if not is_file(path):
        raise InputError(path, "expected a mesh file, found none")
    ending = path.suffix.lower()
    if ending == ".obj":
        mesh = read_obj(path, path.parent, materials)
    elif ending == ".stl":
        mesh = _whole(read_stl_scene(path), materials)
    elif ending == ".ply":
        ignore = (lambda what: None) if materials is None else materials.ignore
        mesh = read_ply_mesh(read_bytes(path, path.parent, MAX_MESH_BYTES), path, ignore)
    elif ending == ".off":
        mesh = read_off_mesh(read_bytes(path, path.parent, MAX_MESH_BYTES), path)
    elif ending == ".msh":
        mesh = read_msh_mesh(read_bytes(path, path.parent, MAX_MESH_BYTES), path)
    elif ending == ".dae":
        scene = read_dae_scene(path)
        mesh = _whole(scene, materials)
        mesh = replace(mesh, vertices=mesh.vertices * (scene.metres_per_unit or 1.0))
    elif ending in (".glb", ".gltf"):
        mesh = _whole(read_glb_scene(path), materials)
    else:
        raise InputError(
            path, "expected a mesh as .obj, .stl, .ply, .off, .msh, .dae, .glb or .gltf: convert it to one of these"
        )
    if mesh is None or not len(mesh.faces):
        raise InputError(path, "has no faces")
    return mesh


def _whole(scene: Scene, materials: MtlMaterials | None) -> Mesh:
    if materials is not None:
        for what in Counter(scene.unread).elements():
            materials.ignore(what)
    return join(*(node.mesh for node in scene.nodes if node.mesh is not None))
