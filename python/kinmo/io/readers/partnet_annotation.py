"""Files that PartNet and PartNet-Mobility share: result.json, its OBJ meshes, and meta.json."""

from __future__ import annotations

import os
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from kinmo.core.categories import canonical_category, same_category
from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh, join
from kinmo.core.wording import clean_text
from kinmo.io.readers.json_field import JsonField
from kinmo.io.readers.mtl_materials import MtlMaterials
from kinmo.io.readers.obj_reader import read_obj
from kinmo.io.readers.part_hierarchy import Hierarchy, Node, build_hierarchy, read_nodes
from kinmo.io.readers.reader import SourceFiles
from kinmo.io.readers.scene import ignored
from kinmo.io.readers.unlisted_meshes import unlisted_meshes
from kinmo.io.readers.untrusted_files import read_json

UNKNOWN_CATEGORY = "unknown"
MOBILITY_FILE = "mobility_v2.json"
HIERARCHY_FILES = ("result.json", "result_after_merging.json")
META_FILE = "meta.json"
MESH_FOLDERS = ("textured_objs", "objs")
PSEUDO_LABEL = "pseudo_label"
"""Field of meta.json that marks predicted joints. It holds the method that predicted them."""


@dataclass(frozen=True)
class Meta:
    """Facts about a shape from meta.json: its canonical category, and the PartNet annotation (`anno_id`) if it is given."""

    category: str
    annotation: str | None
    repairs: tuple[str, ...]


def annotation_files(folder: Path) -> SourceFiles:
    """The files that a shape of PartNet or PartNet-Mobility is read from."""
    return folder.absolute(), [folder / name for name in (MOBILITY_FILE, *HIERARCHY_FILES, META_FILE, *MESH_FOLDERS)]


def read_hierarchy(folder: Path, file: Path) -> Hierarchy:
    """Read the part hierarchy of `file` (result.json or result_after_merging.json) with the meshes of its leaves.

    A mesh that cannot be read is skipped with a note. Raises InputError if no mesh remains.
    """
    roots = read_json(file, folder).items()
    if len(roots) != 1:
        raise InputError(file, f"expected a list of one root, found {len(roots)}")
    nodes = read_nodes(roots[0], "name")
    names = {index: _mesh_names(node) for index, node in enumerate(nodes) if node.is_leaf}
    source = _mesh_folder(folder)
    problems: dict[int, list[InputError]] = {index: [] for index in names}
    unread: Counter[str] = Counter()
    has_materials = any(entry.name.lower().endswith(".mtl") for entry in source.iterdir())  # many copies are without
    materials = MtlMaterials(folder, lambda what: unread.update([what])) if has_materials else None
    meshes = {index: _leaf_mesh(names[index], source, folder, materials, problems[index]) for index in names}
    notes = [
        f"{nodes[index]}: {source.name}/{Path(problem.where).name} skipped: {problem.problem}"
        for index, found in problems.items()
        for problem in found
    ]
    notes += ignored(unread)
    notes += unlisted_meshes(source, {name for leaf in names.values() for name in leaf}, file)
    noted = [index for index, found in problems.items() if len(found) == len(names[index]) > 0]
    return build_hierarchy(nodes, meshes, notes, noted)


def _mesh_folder(folder: Path) -> Path:
    for name in MESH_FOLDERS:
        if os.path.lexists(folder / name):
            if not (folder / name).is_dir():
                raise InputError(folder / name, "expected a folder")
            return folder / name
    raise InputError(folder, f"expected a folder {' or '.join(MESH_FOLDERS)}")


def _mesh_names(node: Node) -> list[str]:
    """File names of the meshes of a leaf, each once."""
    return list(dict.fromkeys(_mesh_name(item) for item in node.field["objs"].items()))


def _leaf_mesh(
    names: list[str], source: Path, folder: Path, materials: MtlMaterials | None, problems: list[InputError]
) -> Mesh:
    """The meshes of a leaf as one. `problems` receives the errors of those that cannot be read."""
    found = []
    for name in names:
        try:
            mesh = read_obj(source / name, folder, materials)
        except InputError as problem:
            problems.append(problem)
        else:
            found += [] if mesh is None else [mesh]
    return join(*found)


def _mesh_name(field: JsonField) -> str:
    """File name of an entry of `objs`, which has no ending."""
    name = field.value
    if isinstance(name, str) and (name in (".", "..") or "/" in name or "\\" in name):
        raise field.fail(f"{clean_text(name)} leads out of the folder of meshes")
    if not isinstance(name, str) or not name or not name.isprintable():
        raise field.fail("expected the name of a mesh")
    return name if name.lower().endswith(".obj") else f"{name}.obj"


def read_meta(folder: Path, root_name: str) -> Meta:
    """Read meta.json.

    Without a category there, the name of the root part gives it. Without both it is `UNKNOWN_CATEGORY`.
    """
    file = folder / META_FILE
    is_missing = not os.path.lexists(file)
    meta = JsonField(file, {}) if is_missing else read_json(file, folder)
    annotation = meta["anno_id"]
    number = (str(annotation.integer()) if isinstance(annotation.value, int) else annotation.text("")) or None
    if meta["model_cat"].is_absent:
        reason = "meta.json is missing" if is_missing else "meta.json has no model_cat"
        if root_name:
            return Meta(canonical_category(root_name), number, (f"{reason}: category taken from the root part",))
        note = f"{reason}, and the root part has no name: category {UNKNOWN_CATEGORY}"
        return Meta(UNKNOWN_CATEGORY, number, (note,))
    name = meta["model_cat"].text()
    if not name:
        raise meta["model_cat"].fail("expected a category")
    repairs = []
    others = {"the root part": root_name, "original_model_cat": meta["original_model_cat"].text("")}
    for place, other in others.items():
        if other and not same_category(name, other):
            repairs.append(f"category {canonical_category(name)} taken from meta.json, {place} says {other}")
    return Meta(canonical_category(name), number, tuple(repairs))


def check_annotated(folder: Path) -> None:
    """Raise InputError if the joints of a shape are pseudo labels, which cannot serve as ground truth."""
    file = folder / META_FILE
    if file.is_file() and not read_json(file, folder)[PSEUDO_LABEL].is_absent:
        raise InputError(
            file, "these joints were predicted, not annotated: they cannot serve as truth for training or scores", PSEUDO_LABEL
        )
