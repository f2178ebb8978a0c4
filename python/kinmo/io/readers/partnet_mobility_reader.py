"""PartNet-Mobility: mobility_v2.json, result.json, textured_objs/, meta.json."""

from __future__ import annotations

from pathlib import Path

from kinmo.core.shape import Shape
from kinmo.core.wording import clean_text
from kinmo.io.readers.partnet_annotation import MOBILITY_FILE, annotation_files, read_hierarchy, read_meta
from kinmo.io.readers.partnet_mobility_bodies import read_mobility
from kinmo.io.readers.reader import Reader

PARTNET_MOBILITY = "partnet_mobility"
_FIRST_OWN_ID = 100_000
"""First id of shapes that do not come from PartNet. Smaller ids are those of PartNet annotations."""


def read_partnet_mobility(folder: Path) -> Shape:
    """Read a shape of PartNet-Mobility.

    Args:
        folder: the folder of the shape.

    Returns:
        The shape with its mobility.

    Raises:
        InputError: the files cannot be used. The message names file and field.
    """
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
        layout=PARTNET_MOBILITY,
        mobility=mobility,
        partnet_id=meta.annotation if comes_from_partnet else None,
        repairs=(*meta.repairs, *hierarchy.repairs, *repairs),
    )


READER = Reader(
    PARTNET_MOBILITY, read_partnet_mobility, annotation_files, is_shape_folder=lambda folder, names: MOBILITY_FILE in names
)
