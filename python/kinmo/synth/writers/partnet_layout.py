"""PartNet's layout: result.json, result_after_merging.json, meta.json and objs/, without mobility."""

from __future__ import annotations

from itertools import count
from pathlib import Path
from typing import Any

from kinmo.synth.draw import Draw
from kinmo.synth.synth_object import Node, SynthObject
from kinmo.synth.writers.node_numbering import Numbering, number
from kinmo.synth.writers.text_files import write_json, write_obj


def write(obj: SynthObject, shape_id: str, folder: Path, draw: Draw) -> None:
    """Write an object as an unlabelled shape of PartNet."""
    numbering = number(obj, draw)
    write_hierarchy(obj, shape_id, folder, numbering, "objs")
    write_merged(obj, folder, numbering)


def write_hierarchy(obj: SynthObject, shape_id: str, folder: Path, numbering: Numbering, meshes: str) -> None:
    """Write result.json, meta.json, and the OBJ files in the subfolder `meshes`."""
    (folder / meshes).mkdir(parents=True)
    for leaf, names in numbering.files.items():
        for name, piece in zip(names, leaf.pieces, strict=True):
            write_obj(folder / meshes / f"{name}.obj", piece)
    write_json(folder / "result.json", [numbering.tree(obj.root)])
    meta = {"user_id": "kinmo", "model_cat": obj.category, "model_id": shape_id, "version": "1", "anno_id": shape_id}
    write_json(folder / "meta.json", meta)


def write_merged(obj: SynthObject, folder: Path, numbering: Numbering) -> None:
    """Write result_after_merging.json: new ids in preorder, all files of a subtree at every node, single children merged."""
    write_json(folder / "result_after_merging.json", [_merged(obj.root, numbering, count())])


def _merged(node: Node, numbering: Numbering, ids: count[int]) -> dict[str, Any]:
    """PartNet's merged form of a node. A node with a single child is replaced by that child."""
    kept = node
    while len(kept.children) == 1:
        kept = kept.children[0]
    fields: dict[str, Any] = {"id": next(ids), "ori_id": numbering.ids[kept], "name": kept.name, "text": kept.name}
    fields["objs"] = [name for leaf in kept.leaves() for name in numbering.files[leaf]]
    if kept.children:
        fields["children"] = [_merged(child, numbering, ids) for child in kept.children]
    return fields
