"""Ids of nodes and names of OBJ files, as PartNet's files have them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from kinmo.synth.draw import Draw
from kinmo.synth.model import Node, SynthObject


@dataclass(frozen=True, eq=False)
class Numbering:
    """`ids` of nodes, unique in an object, and the `files` (without suffix) of every leaf's pieces."""

    ids: dict[Node, int]
    files: dict[Node, tuple[str, ...]]

    def tree(self, node: Node) -> dict[str, Any]:
        """The node as result.json has it."""
        fields: dict[str, Any] = {"text": node.name.replace("_", " ").title() if node.children else node.name}
        if node.children:
            fields["children"] = [self.tree(child) for child in node.children]
        else:
            fields["objs"] = list(self.files[node])
        return fields | {"id": self.ids[node], "name": node.name}


def number(obj: SynthObject, draw: Draw) -> Numbering:
    """Preorder ids with the gaps and late numbers that editing leaves; "new-" files where parts were cut again."""
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
