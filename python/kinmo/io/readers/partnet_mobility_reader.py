"""PartNet-Mobility: mobility_v2.json, result.json, textured_objs/, meta.json."""

from __future__ import annotations

from pathlib import Path

from kinmo.core.shape import Shape
from kinmo.io.readers.field import clean_text
from kinmo.io.readers.mobility_bodies import read_mobility
from kinmo.io.readers.partnet_annotation import read_hierarchy, read_meta

_FIRST_OWN_ID = 100_000
"""Shapes below it come from PartNet and keep their annotation's number; later ones are numbered apart from it."""


def read_partnet_mobility(folder: Path) -> Shape:
    """Reads a shape of PartNet-Mobility. Raises InputError, naming file and field, for what cannot be used."""
    folder = Path(folder)
    hierarchy = read_hierarchy(folder, folder / "result.json")
    repairs: list[str] = []
    mobility = read_mobility(folder, hierarchy, repairs)
    meta = read_meta(folder, hierarchy.parts[0].name)
    name = folder.resolve().name
    comes_from_partnet = not (name.isdecimal() and int(name[:12]) >= _FIRST_OWN_ID)
    return Shape(
        id=clean_text(name),
        category=meta.category,
        parts=hierarchy.parts,
        source=folder,
        layout="partnet_mobility",
        mobility=mobility,
        partnet_id=meta.annotation if comes_from_partnet else None,
        repairs=(*meta.repairs, *hierarchy.repairs, *repairs),
    )
