"""Node ids and OBJ file names in the style of PartNet's files."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from kinmo.synth.draw import Draw
from kinmo.synth.synth_object import Node, SynthObject


@dataclass(frozen=True, eq=False)
class Numbering:
    """Ids and file names of one object.

    Attributes:
        ids: Id of each node, unique in the object.
        files: File names, without suffix, of each leaf's pieces.
    """

    ids: dict[Node, int]
    files: dict[Node, tuple[str, ...]]

    def tree(self, node: Node) -> dict[str, Any]:
        """The node and all below it as result.json states them."""
        fields: dict[str, Any] = {"text": node.name.replace("_", " ").title() if node.children else node.name}
        if node.children:
            fields["children"] = [self.tree(child) for child in node.children]
        else:
            fields["objs"] = list(self.files[node])
        return fields | {"id": self.ids[node], "name": node.name}


def number(obj: SynthObject, draw: Draw) -> Numbering:
    """Number an object's nodes and files at random, as if annotators had edited them.

    Args:
        obj: The object.
        draw: Random values of the files.

    Returns:
        Preorder ids with gaps and some late numbers, and "original-" or "new-" file names. Parts that were cut again have the
        latter.
    """
    ids, files = {}, {}
    following = 0
    file_number = draw.integer(0, 3)
    cut_again = draw.chance(0.3)
    late = [node for node in obj.root.walk() if node is not obj.root and draw.chance(0.1)] if draw.chance(0.5) else []
    nodes = [node for node in obj.root.walk() if node not in late] + late
    for node in nodes:
        ids[node] = following
        following += 1 if draw.chance(0.95) else draw.integer(2, 5)
    for leaf in obj.root.leaves():
        names = []
        for _ in leaf.pieces:
            names.append(f"{'new' if cut_again and draw.chance(0.5) else 'original'}-{file_number}")
            file_number += 1 if draw.chance(0.9) else 2
        files[leaf] = tuple(names)
    return Numbering(ids, files)
