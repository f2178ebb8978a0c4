"""PartNet: result.json or result_after_merging.json, objs/, meta.json."""

from __future__ import annotations

from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.core.shape import Shape
from kinmo.io.readers.field import clean_text
from kinmo.io.readers.partnet_annotation import read_hierarchy, read_meta

HIERARCHY_FILES = ("result.json", "result_after_merging.json")


def read_partnet(folder: Path) -> Shape:
    """Reads a shape of PartNet. Raises InputError, naming file and field, for what cannot be used."""
    folder = Path(folder)
    file = next((folder / name for name in HIERARCHY_FILES if (folder / name).exists()), None)
    if file is None:
        raise InputError(folder, f"expected {' or '.join(HIERARCHY_FILES)}")
    hierarchy = read_hierarchy(folder, file)
    meta = read_meta(folder, hierarchy.parts[0].name)
    name = clean_text(folder.resolve().name)
    return Shape(
        id=name,
        category=meta.category,
        parts=hierarchy.parts,
        source=folder,
        layout="partnet",
        partnet_id=meta.annotation or name,
        repairs=(*meta.repairs, *hierarchy.repairs),
    )
