"""Forms in which one object may come: as a hierarchy, as a flat list of parts, without names, as loose pieces of one mesh.

Joints are kept: every part of a form belongs to the body that its surface came from.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinmo.core.loose_pieces import MAX_PIECES, pieces_of_faces
from kinmo.core.mobility import Mobility
from kinmo.core.shape import Mesh, Part, Shape, join

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
    """

    name: str
    mesh: Mesh
    body: int | None = None
    is_junk: bool = False


def flat_parts(shape: Shape) -> list[FlatPart]:
    """The leaves of a shape as a flat list."""
    mobility = shape.mobility or Mobility(())
    owner = {leaf: index for index, body in enumerate(mobility.bodies) for leaf in body.leaves}
    return [FlatPart(shape.parts[i].name, shape.leaf_mesh(i), owner.get(i), i in mobility.junk) for i in shape.leaves]


def flat_shape(shape: Shape, parts: Sequence[FlatPart]) -> Shape:
    """`shape` with its parts replaced by a flat list below one root. Bodies that no part belongs to are left out."""
    root = Part(0, ROOT_NAME, None, tuple(range(1, len(parts) + 1)))
    leaves = [Part(i, part.name, 0, (), part.mesh) for i, part in enumerate(parts, start=1)]
    mobility = None if shape.mobility is None else _mobility_of(shape.mobility, parts)
    return replace(shape, parts=(root, *leaves), mobility=mobility)


def _mobility_of(mobility: Mobility, parts: Sequence[FlatPart]) -> Mobility:
    """The mobility with the leaves of a flat list, whose first part has the index 1."""
    owned: dict[int, list[int]] = {}
    for index, part in enumerate(parts, start=1):
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
    return Mobility(bodies, frozenset(index for index, part in enumerate(parts, start=1) if part.is_junk))


def without_names(parts: Sequence[FlatPart], rng: np.random.Generator) -> list[FlatPart]:
    """The parts in random order, called part_0, part_1 and so on."""
    return [replace(parts[old], name=f"part_{new}") for new, old in enumerate(rng.permutation(len(parts)))]


def in_pieces(parts: Sequence[FlatPart], *, most: int = MAX_PIECES) -> list[FlatPart]:
    """The loose pieces of all parts together, without names. A piece belongs where most of its area comes from."""
    whole = join(*(part.mesh for part in parts))
    pieces = pieces_of_faces(whole, most=most)
    origin = np.repeat(np.arange(len(parts)), [len(part.mesh.faces) for part in parts])
    share = np.zeros((int(pieces.max()) + 1, len(parts)))
    np.add.at(share, (pieces, origin), whole.face_areas)
    found = []
    for piece, source in enumerate(share.argmax(axis=1)):
        mesh = Mesh(whole.vertices, whole.faces[pieces == piece]).compact
        found.append(replace(parts[source], name="", mesh=mesh))
    return found
