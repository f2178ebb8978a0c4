"""Forms in which one object may come: as a hierarchy, as a flat list of parts, without names, as loose pieces of one mesh.

Joints are kept: every part of a form belongs to the body that its surface came from.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinmo.core.loose_pieces import MAX_PIECES, pieces_of_faces
from kinmo.core.mesh_splitting import split_mesh
from kinmo.core.mobility import Mobility
from kinmo.core.shape import Mesh, Part, Shape, join
from kinmo.core.surface_patches import patches_of_faces

ROOT_NAME = "object"
"""Name of the root of a flat shape."""


@dataclass(frozen=True, eq=False)
class FlatPart:
    """A part of a flat list.

    Attributes:
        name: name of the part.
        mesh: its geometry.
        body: index of its body in the mobility. None without an annotation.
        is_junk: True if the annotation marks it as not belonging to the object.
        piece: number of the loose piece that it is a patch of. None if it is a part of its own.
    """

    name: str
    mesh: Mesh
    body: int | None = None
    is_junk: bool = False
    piece: int | None = None


def flat_parts(shape: Shape) -> list[FlatPart]:
    """The leaves of a shape as a flat list."""
    mobility = shape.mobility or Mobility(())
    owner = {leaf: index for index, body in enumerate(mobility.bodies) for leaf in body.leaves}
    return [FlatPart(shape.parts[i].name, shape.leaf_mesh(i), owner.get(i), i in mobility.junk) for i in shape.leaves]


def flat_shape(shape: Shape, parts: Sequence[FlatPart]) -> Shape:
    """`shape` with its parts replaced by a flat list below one root, where patches of one loose piece have a node of their own.

    Bodies that no part belongs to are left out.
    """
    together: dict[int | str, list[FlatPart]] = {}
    for place, part in enumerate(parts):
        together.setdefault(place if part.piece is None else f"piece {part.piece}", []).append(part)
    nodes: list[Part] = []
    top: list[int] = []
    leaves: dict[int, FlatPart] = {}
    for patches in together.values():
        above, first = 0, len(nodes) + 1
        top.append(first)
        if len(patches) > 1:
            nodes.append(Part(first, "", 0, tuple(range(first + 1, first + 1 + len(patches)))))
            above = first
        for part in patches:
            leaves[len(nodes) + 1] = part
            nodes.append(Part(len(nodes) + 1, part.name, above, (), part.mesh))
    mobility = None if shape.mobility is None else _mobility_of(shape.mobility, leaves)
    return replace(shape, parts=(Part(0, ROOT_NAME, None, tuple(top)), *nodes), mobility=mobility)


def _mobility_of(mobility: Mobility, parts: Mapping[int, FlatPart]) -> Mobility:
    """The mobility with other leaves, by their indices."""
    owned: dict[int, list[int]] = {}
    for index, part in parts.items():
        if part.body is not None:
            owned.setdefault(part.body, []).append(index)
    place = {body: new for new, body in enumerate(sorted(owned))}

    def parent(body: int) -> int | None:
        """The nearest body above one that has parts."""
        above = mobility.bodies[body].parent
        return above if above is None or above in owned else parent(above)

    above = {body: parent(body) for body in owned}
    bodies = tuple(
        replace(
            mobility.bodies[body],
            leaves=tuple(owned[body]),
            parent=None if (holder := above[body]) is None else place[holder],
        )
        for body in sorted(owned)
    )
    return Mobility(bodies, frozenset(index for index, part in parts.items() if part.is_junk))


def without_names(parts: Sequence[FlatPart], rng: np.random.Generator) -> list[FlatPart]:
    """The parts in random order, called part_0, part_1 and so on."""
    return [replace(parts[old], name=f"part_{new}") for new, old in enumerate(rng.permutation(len(parts)))]


def in_pieces(parts: Sequence[FlatPart], *, most: int = MAX_PIECES) -> list[FlatPart]:
    """The patches of all parts together, without names. A patch belongs where most of its area comes from.

    Args:
        parts: The parts.
        most: Most loose pieces, and most patches where there are fewer loose pieces.
    """
    whole = join(*(part.mesh for part in parts))
    pieces = pieces_of_faces(whole, most=most)
    patches = patches_of_faces(whole, pieces, most=most)
    origin = np.repeat(np.arange(len(parts)), [len(part.mesh.faces) for part in parts])
    share = np.zeros((int(patches.max()) + 1, len(parts)))
    np.add.at(share, (patches, origin), whole.face_areas)
    _, first = np.unique(patches, return_index=True)
    meshes = split_mesh(whole, patches)
    return [
        replace(parts[source], name="", mesh=mesh, piece=int(pieces[face]))
        for source, mesh, face in zip(share.argmax(axis=1), meshes, first, strict=True)
    ]
