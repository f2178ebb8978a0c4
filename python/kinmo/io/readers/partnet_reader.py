"""PartNet: result.json or result_after_merging.json, objs/, meta.json."""

from __future__ import annotations

import re
from collections.abc import Set as AbstractSet
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.core.shape import Shape
from kinmo.core.wording import clean_text
from kinmo.io.readers.partnet_annotation import HIERARCHY_FILES, MESH_FOLDERS, annotation_files, read_hierarchy, read_meta
from kinmo.io.readers.reader import Reader
from kinmo.io.readers.untrusted_files import peek

PARTNET = "partnet"


def read_partnet(folder: Path) -> Shape:
    """Read the shape in a folder, without mobility. Raises InputError if the files cannot be used."""
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
        layout=PARTNET,
        partnet_id=meta.annotation or name,
        repairs=(*meta.repairs, *hierarchy.repairs),
    )


def _is_shape_folder(folder: Path, names: AbstractSet[str]) -> bool:
    """True for a hierarchy file with meshes beside it, or one that looks like PartNet's, to report it as incomplete."""
    file = next((name for name in HIERARCHY_FILES if name in names), None)
    if file is None:
        return False
    if not names.isdisjoint(MESH_FOLDERS):
        return True
    text = peek(folder / file, folder)
    return bool(re.match(rb"\s*\[\s*\{", text)) and b'"name"' in text and b'"id"' in text


READER = Reader(PARTNET, read_partnet, annotation_files, is_shape_folder=_is_shape_folder)
