"""A scene: nodes with meshes, in the frame of a 3D file. `kinmo.io.readers.scene_shape` makes a shape of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError
from kinmo.core.frames import Axis
from kinmo.core.shape import Mesh, join
from kinmo.core.wording import clean_text
from kinmo.io.readers.mesh_limits import checked
from kinmo.io.readers.part_hierarchy import MAX_DEPTH

F64 = NDArray[np.float64]

MAX_CORNERS = 20_000_000
"""Most vertices and indices of all meshes together. A small file may show one mesh many times."""
MAX_NODES = 100_000
"""Most nodes of a scene, including nodes that are no parts, such as bones."""


@dataclass(frozen=True, eq=False)
class SceneNode:
    """A node of a scene.

    Attributes:
        name: name in the file, as one printable line. Empty if it has none.
        parent: index into the nodes of the scene. None for the root.
        mesh: its own triangles in the frame of the scene. None if it has none.
    """

    name: str
    parent: int | None
    mesh: Mesh | None = None


@dataclass(frozen=True, eq=False)
class Scene:
    """A scene of a 3D file.

    Attributes:
        path: the file.
        layout: name of the format, as in `Shape.layout`.
        nodes: the nodes in the order of the file: one root that stands for the scene, every parent before its children.
        up: axis that points up.
        convention: what states `up`, for people: the name of the format, or "file".
        metres_per_unit: length of a unit in metres. None if neither the file nor its format states it.
        usual_unit: length of a unit in metres that a large object has if `metres_per_unit` is None. None to guess it.
        unread: what was not read, with its count.
        file_order: indices [F] that put the joined faces of all meshes in the order of the file. None if they have that order.
    """

    path: Path
    layout: str
    nodes: tuple[SceneNode, ...]
    up: Axis
    convention: str
    metres_per_unit: float | None
    usual_unit: float | None = None
    unread: Mapping[str, int] = field(default_factory=dict)
    file_order: NDArray[np.int64] | None = None

    @property
    def repairs(self) -> tuple[str, ...]:
        """One line for everything that was not read."""
        return ignored(self.unread)

    @property
    def whole(self) -> Mesh:
        """All meshes as one, with their faces in the order of the file."""
        mesh = join(*(node.mesh for node in self.nodes if node.mesh is not None))
        return mesh if self.file_order is None else mesh.part(self.file_order)


class CornerBudget:
    """Counts corners of meshes, to refuse files that expand to more than `MAX_CORNERS`."""

    def __init__(self, where: Path) -> None:
        self.where = where
        self._count = 0

    def spend(self, corners: int) -> None:
        """Count vertices or indices. Raises InputError if there are too many."""
        self._count += corners
        if self._count > MAX_CORNERS:
            raise InputError(self.where, f"more than {MAX_CORNERS} corners: simplify its meshes")


class SceneBuilder:
    """Collects the nodes of a scene. It refuses broken meshes, and scenes that are too large or too deep."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._nodes = [SceneNode("", None)]
        self._depths = [0]
        self._budget = CornerBudget(path)
        self._ignored: Counter[str] = Counter()

    def add(self, name: str, parent: int = 0, mesh: Mesh | None = None, pose: F64 | None = None) -> int:
        """Add a node, and get its index.

        Args:
            name: Its name in the file, of any form.
            parent: Index of the node above it.
            mesh: Its triangles.
            pose: Transform [4, 4] of the mesh to the scene. None if it is there already.
        """
        if len(self._nodes) > MAX_NODES:
            raise InputError(self.path, f"more than {MAX_NODES} nodes")
        if self._depths[parent] >= MAX_DEPTH:
            raise InputError(self.path, f"nested deeper than {MAX_DEPTH} levels: export it with fewer")
        if mesh is not None:
            self._budget.spend(len(mesh.vertices) + mesh.faces.size)
            if len(mesh.faces) and int(mesh.faces.max()) >= len(mesh.vertices):
                raise InputError(self.path, f"a face names a vertex outside 0..{len(mesh.vertices) - 1}")
            mesh = placed(mesh.compact, np.eye(4) if pose is None else pose, self.path)
        self._nodes.append(SceneNode(clean_text(name), parent, mesh))
        self._depths.append(self._depths[parent] + 1)
        return len(self._nodes) - 1

    def ignore(self, what: str) -> None:
        """Count something that is not read, such as "points and lines"."""
        self._ignored[what] += 1

    def scene(
        self, layout: str, convention: str, up: Axis, metres_per_unit: float | None, usual_unit: float | None = None
    ) -> Scene:
        """The scene of all nodes. The arguments are fields of `Scene`."""
        return Scene(self.path, layout, tuple(self._nodes), up, convention, metres_per_unit, usual_unit, self._ignored)


def placed(mesh: Mesh, pose: F64, where: Path) -> Mesh:
    """A mesh moved by a transform [4, 4]. Mirrored triangles are flipped, so that they still face outwards.

    Raises InputError for positions that are not finite or too large.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        moved = mesh.moved(pose[:3, :3], pose[:3, 3])
        is_mirrored = np.linalg.det(pose[:3, :3]) < 0.0
    return checked(moved.flipped if is_mirrored else moved, where)


def ignored(counts: Mapping[str, int] | Iterable[tuple[str, int]]) -> tuple[str, ...]:
    """A repair line for each kind of thing that was ignored, with its count, in alphabetical order."""
    return tuple(f"{what} ignored: {count}" for what, count in sorted(dict(counts).items()) if count)
