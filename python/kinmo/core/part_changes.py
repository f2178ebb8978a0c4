"""Random changes of a flat list of parts, as users' files have them: merged and split parts, screws, missing details.

No change mixes the bodies: every part still belongs to one body, so that joints stay true.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kinmo.core.loose_pieces import loose_pieces
from kinmo.core.oriented_box import CORNER_SIGNS
from kinmo.core.shape import Mesh, bounds_of, join
from kinmo.core.shape_forms import FlatPart

MERGED_SHARE = 0.45
"""Share of lists in which touching parts of one body are merged."""
SPLIT_SHARE = 0.5
"""Share of lists in which parts are split."""
STUDDED_SHARE = 0.3
"""Share of lists that get tiny parts, such as screws."""
THINNED_SHARE = 0.2
"""Share of lists that lose small parts."""
TOUCHING = 0.01
"""Distance between the boxes of touching parts, in diagonals."""
MAX_PIECES = 12
"""Most parts that one part is split into."""
STUD_SIZES = (0.002, 0.008)
"""Smallest and largest radius of a tiny part, in diagonals."""
MAX_STUDS = 24
"""Most tiny parts."""
STUD_NAMES = ("screw", "bolt", "label", "foot", "pad", "decal", "rivet")
"""Names of tiny parts."""
SMALL_AREA = 0.01
"""Share of the whole surface below which a part may be lost."""
SMALL_AREA_OF_BODY = 0.2
"""Share of its body's surface below which a part may be lost."""
_BOX_FACES = np.array(
    [
        *((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)),
        *((2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)),
    ],
    np.uint32,
)
"""Corners of the triangles of a box, as indices into `CORNER_SIGNS`."""


def changed_parts(parts: Sequence[FlatPart], rng: np.random.Generator) -> list[FlatPart]:
    """The parts after some random changes, drawn from `rng`."""
    low, high = bounds_of(part.mesh for part in parts)
    diagonal = float(np.linalg.norm(high - low))
    changed = list(parts)
    if rng.random() < MERGED_SHARE:
        for _ in range(rng.integers(1, 1 + max(1, len(changed) // 2))):
            changed = _merged(changed, rng, TOUCHING * diagonal)
    if rng.random() < SPLIT_SHARE:
        for _ in range(rng.integers(1, 4)):
            changed = _split(changed, rng)
    if rng.random() < STUDDED_SHARE:
        changed = _studded(changed, rng, diagonal)
    return _thinned(changed, rng) if rng.random() < THINNED_SHARE else changed


def _merged(parts: list[FlatPart], rng: np.random.Generator, reach: float) -> list[FlatPart]:
    """Join a part with one of the same body that touches it, under the name of the larger one."""
    first = parts[rng.integers(len(parts))]
    low, high = bounds_of([first.mesh])

    def touches(part: FlatPart) -> bool:
        its_low, its_high = bounds_of([part.mesh])
        return float(np.linalg.norm(np.maximum(np.maximum(its_low - high, low - its_high), 0.0))) < reach

    alike = [part for part in parts if part is not first and (part.body, part.is_junk) == (first.body, first.is_junk)]
    near = [part for part in alike if touches(part)]
    if not near:
        return parts
    second = near[rng.integers(len(near))]
    larger = max(first, second, key=lambda part: part.mesh.face_areas.sum())
    others = [part for part in parts if part is not first and part is not second]
    return [*others, replace(larger, mesh=join(first.mesh, second.mesh))]


def _split(parts: list[FlatPart], rng: np.random.Generator) -> list[FlatPart]:
    """Divide a part into its loose pieces, along a plane, or into its flat sides."""
    part = parts[rng.integers(len(parts))]
    way = rng.random()
    if way < 0.5:
        meshes = loose_pieces(part.mesh, most=MAX_PIECES)
    else:
        meshes = _divided(part.mesh, _halves(part.mesh, rng) if way < 0.8 else _sides(part.mesh))
    if not 1 < len(meshes) <= MAX_PIECES:
        return parts
    if len(meshes) > 2 and rng.random() < 0.3:
        meshes = [meshes[0], join(*meshes[1:])]
    return [*(other for other in parts if other is not part), *(replace(part, mesh=mesh) for mesh in meshes)]


def _halves(mesh: Mesh, rng: np.random.Generator) -> NDArray[np.int64]:
    """Side [F] of every face relative to a plane across one axis of the file."""
    middles = mesh.triangles.mean(axis=1)[:, rng.integers(3)]
    cut = middles.min() + rng.uniform(0.25, 0.75) * np.ptp(middles)
    return np.asarray(middles < cut, np.int64)


def _sides(mesh: Mesh) -> NDArray[np.int64]:
    """Number [F] of the direction that every face looks to."""
    first, second, third = np.moveaxis(mesh.triangles, 1, 0)
    normals = np.cross(second - first, third - first)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    _, side = np.unique(np.round(2.0 * normals).astype(np.int64), axis=0, return_inverse=True)
    return np.asarray(side.ravel(), np.int64)


def _divided(mesh: Mesh, label: NDArray[np.int64]) -> list[Mesh]:
    return [mesh.part(label == each) for each in np.unique(label)]


def _studded(parts: list[FlatPart], rng: np.random.Generator, diagonal: float) -> list[FlatPart]:
    """Add tiny discs or blocks to the surfaces of a few parts; now and then all those of a body are one part."""
    name, radius = STUD_NAMES[rng.integers(len(STUD_NAMES))], float(rng.uniform(*STUD_SIZES)) * diagonal
    is_round = rng.random() < 0.7
    hosts = [parts[i] for i in rng.choice(len(parts), min(len(parts), int(rng.integers(1, 4))), replace=False)]
    studs: list[FlatPart] = []
    for _ in range(int(np.exp(rng.uniform(0.0, np.log(MAX_STUDS))))):
        host = hosts[rng.integers(len(hosts))]
        areas = host.mesh.face_areas
        if not areas.sum() > 0.0:
            continue
        corners = host.mesh.triangles[rng.choice(len(areas), p=areas / areas.sum())]
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        place, normal = rng.dirichlet([1.0, 1.0, 1.0]) @ corners, normal / np.linalg.norm(normal)
        stud = _disc(place, normal, radius) if is_round else _block(place, radius * rng.uniform(0.3, 1.5, 3))
        studs.append(replace(host, name=name, mesh=stud))
    if rng.random() < 0.3:
        bodies: dict[tuple[int | None, bool], list[FlatPart]] = {}
        for part in studs:
            bodies.setdefault((part.body, part.is_junk), []).append(part)
        studs = [replace(some[0], mesh=join(*(part.mesh for part in some))) for some in bodies.values()]
    return [*parts, *studs]


def _block(center: NDArray[np.float64], half: NDArray[np.float64]) -> Mesh:
    return Mesh(center + CORNER_SIGNS * half, _BOX_FACES)


def _disc(center: NDArray[np.float64], axis: NDArray[np.float64], radius: float, sides: int = 10) -> Mesh:
    """A flat cylinder on the plane through `center` across `axis`."""
    across = np.cross(axis, [1.0, 0.0, 0.0] if abs(axis[0]) < 0.9 else [0.0, 1.0, 0.0])
    across /= np.linalg.norm(across)
    angles = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)[:, None]
    ring = center + radius * (np.cos(angles) * across + np.sin(angles) * np.cross(axis, across))
    top = 0.4 * radius * axis
    here, after = np.arange(sides), np.roll(np.arange(sides), -1)
    low, high = np.full(sides, 2 * sides), np.full(sides, 2 * sides + 1)
    rows = (
        (here, after, sides + after),
        (here, sides + after, sides + here),
        (low, after, here),
        (high, sides + here, sides + after),
    )
    faces = np.concatenate([np.stack(row, axis=1) for row in rows])
    return Mesh(np.concatenate([ring, ring + top, [center], [center + top]]), faces.astype(np.uint32))


def _thinned(parts: list[FlatPart], rng: np.random.Generator) -> list[FlatPart]:
    """Leave out half of the small parts; no body loses all of its parts."""
    areas = [float(part.mesh.face_areas.sum()) for part in parts]
    of_body: dict[int | None, float] = {}
    for part, area in zip(parts, areas, strict=True):
        of_body[part.body] = of_body.get(part.body, 0.0) + area
    return [
        part
        for part, area in zip(parts, areas, strict=True)
        if area >= min(SMALL_AREA * sum(areas), SMALL_AREA_OF_BODY * of_body[part.body]) or rng.random() < 0.5
    ]
