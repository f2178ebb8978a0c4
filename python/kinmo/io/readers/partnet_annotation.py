"""What PartNet and PartNet-Mobility share: result.json, its meshes, and meta.json."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from kinmo.core.categories import canonical_category, same_category
from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh, join
from kinmo.io.readers.field import Field, clean_text
from kinmo.io.readers.mesh_checks import has_surface
from kinmo.io.readers.obj_reader import read_obj
from kinmo.io.readers.part_hierarchy import Hierarchy, Node, build, walk
from kinmo.io.readers.untrusted_files import inside, read_json

UNKNOWN_CATEGORY = "unknown"
MESH_FOLDERS = ("textured_objs", "objs")
META = "meta.json"
PSEUDO_LABEL = "pseudo_label"
"""A field of meta.json: what the joints were predicted by, where nobody annotated them."""


@dataclass(frozen=True)
class Meta:
    """What is known of a shape beside its parts. `annotation` is the `anno_id` of meta.json."""

    category: str
    annotation: str | None
    repairs: tuple[str, ...]


def read_hierarchy(folder: Path, file: Path) -> Hierarchy:
    """The hierarchy of result.json or result_after_merging.json, with a mesh a leaf."""
    roots = Field(file, read_json(file, folder)).items()
    if len(roots) != 1:
        raise InputError(file, f"expected a list of one root, found {len(roots)}")
    nodes = walk(roots[0], "name")
    source = mesh_folder(folder)
    meshes = {}
    for index, node in enumerate(nodes):
        if node.is_leaf and (mesh := _leaf_mesh(node, source, folder)) is not None:
            meshes[index] = mesh
    return build(nodes, meshes)


def mesh_folder(folder: Path) -> Path:
    """The folder of the OBJ files."""
    for name in MESH_FOLDERS:
        if (folder / name).exists() or (folder / name).is_symlink():
            real = inside(folder / name, folder)
            if not real.is_dir():
                raise InputError(folder / name, "expected a folder")
            return real
    raise InputError(folder, f"expected a folder {' or '.join(MESH_FOLDERS)}")


def _leaf_mesh(node: Node, source: Path, folder: Path) -> Mesh | None:
    names = list(dict.fromkeys(_mesh_name(item) for item in node.field["objs"].items()))
    meshes = [mesh for name in names if (mesh := read_obj(source / name, folder)) is not None]
    if not meshes:
        return None
    mesh = join(*meshes)
    return mesh if has_surface(mesh) else None


def _mesh_name(field: Field) -> str:
    """The file of an entry of `objs`, which names it without its ending."""
    name = field.value
    if not isinstance(name, str) or not name:
        raise field.fail("expected the name of a mesh")
    if name in (".", "..") or "/" in name or "\\" in name:
        raise field.fail(f"{clean_text(name)} leads out of the folder of meshes")
    if not name.isprintable():
        raise field.fail("expected the name of a mesh")
    return name if name.lower().endswith(".obj") else f"{name}.obj"


def read_meta(folder: Path, root_name: str) -> Meta:
    """Category and annotation. meta.json decides, without it the name of the root part; without both it is unknown."""
    file = folder / META
    if not file.exists() and not file.is_symlink():
        category, repair = _category_of_root(root_name, "meta.json is missing")
        return Meta(category, None, (repair,))
    meta = Field(file, read_json(file, folder))
    annotation = meta["anno_id"]
    number = (str(annotation.integer()) if isinstance(annotation.value, int) else annotation.text("")) or None
    if meta["model_cat"].is_absent:
        category, repair = _category_of_root(root_name, "meta.json has no model_cat")
        return Meta(category, number, (repair,))
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
    """Raises InputError if the joints of a shape are pseudo labels, and so nothing to learn from as truth or to judge by."""
    file = folder / META
    if file.is_file() and not Field(file, read_json(file, folder))[PSEUDO_LABEL].is_absent:
        raise InputError(
            file, "these joints were predicted and not annotated: no truth to train on or to judge by", PSEUDO_LABEL
        )


def _category_of_root(name: str, reason: str) -> tuple[str, str]:
    """The category that the root part's name says, and what is to be told of it."""
    if name:
        return canonical_category(name), f"{reason}: category taken from the root part"
    return UNKNOWN_CATEGORY, f"{reason}, and the root part has no name: category {UNKNOWN_CATEGORY}"
