"""How an annotator arranged the hierarchy: nested as in PartNet, or one leaf a body; grouped well, or not.

Both kinds are about equally common among real objects, and for a tenth of their joints no single node is the moving part.
"""

from __future__ import annotations

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.model import JointName, Link, Node, SynthObject

LUMPED_SHARE = 0.15
"""Share of nested objects that are written with one leaf a body, besides those that families build so."""
TORN_SHARE = 0.09
"""Share of moving links whose parts end up under different nodes."""
WRAPPED_SHARE = 0.03
"""Share of leaves that get an inner node with a single child above them."""
JUNK_SHARE = 0.1
"""Share of objects in which a leaf is marked as not belonging."""


def is_nested(obj: SynthObject) -> bool:
    """Whether the hierarchy has inner nodes besides the root, as PartNet's annotations have."""
    return any(child.children for child in obj.root.children)


def arrange(obj: SynthObject, draw: Draw) -> None:
    """Give the hierarchy its style, in place. Links keep exactly their geometry."""
    if is_nested(obj) and draw.chance(LUMPED_SHARE):
        lump(obj, draw)
    for link in obj.links:
        if link.motion is not None and draw.chance(TORN_SHARE):
            tear(obj, link, draw)
    for node in list(obj.root.walk()):
        for place, child in enumerate(node.children):
            if not child.children and draw.chance(WRAPPED_SHARE):
                wrap(obj, node, place)
    if draw.chance(JUNK_SHARE):
        discard_leaf(obj, draw)


def lump(obj: SynthObject, draw: Draw) -> None:
    """One leaf a link, all directly below the root: moving parts first, what stands still last."""
    root = Node(obj.category)
    moving = [link for link in obj.links if link.motion is not None]
    standing = [link for link in obj.links if link.motion is None]
    for link in moving + standing:
        pieces = [piece for leaf in link.leaves() for piece in leaf.pieces]
        name = link.lumped_name or (link.name if link.motion is not None else "base_body")
        link.nodes = [root.add(name, *pieces)]
    obj.root = root
    if draw.chance(0.4):
        draw_order = sorted(range(len(moving)), key=lambda _: draw.integer(0, 1 << 30))
        root.children[: len(moving)] = [root.children[i] for i in draw_order]


def tear(obj: SynthObject, link: Link, draw: Draw) -> None:
    """Put a part of a link under another node than the rest, so that no single node is the moving part."""
    parents = {child: node for node in obj.root.walk() for child in node.children}
    if len(link.nodes) != 1 or link.nodes[0] not in parents:
        return
    node, above = link.nodes[0], parents[link.nodes[0]]
    if node.children:
        above.children[above.children.index(node) : above.children.index(node) + 1] = node.children
        link.nodes = list(node.children)
    elif len(node.pieces) > 1:
        taken = draw.integer(1, max(1, len(node.pieces) // 2))
        outlier = Node(draw.pick(["outlier", "other", "handle"], [3, 1, 1]), pieces=node.pieces[-taken:])
        node.pieces = node.pieces[:-taken]
        obj.root.children.append(outlier)
        link.nodes.append(outlier)


def wrap(obj: SynthObject, above: Node, place: int) -> None:
    """Put the leaf at `place` below an inner node of its own, as "other" often has a single "other_leaf"."""
    leaf = above.children[place]
    name = "other" if leaf.name.startswith("other") or above is obj.root else leaf.name
    above.children[place] = Node(name, [leaf])


def discard_leaf(obj: SynthObject, draw: Draw) -> None:
    """Mark a leaf that does not move, and is not all that stands still, as junk."""
    for link in obj.links:
        spare = [leaf for leaf in link.leaves() if len(list(link.leaves())) > 2]
        if link.motion is None and link.parent is None and spare:
            leaf = min(spare, key=lambda node: _extent(node.pieces))
            link.nodes = [other for other in link.leaves() if other is not leaf]
            leaf.name = draw.pick(["other_leaf", "outlier", leaf.name], [2, 1, 1])
            obj.links.append(Link(leaf.name, [leaf], kind=JointName.JUNK))
            return


def _extent(pieces: list[Mesh]) -> float:
    return max(float((piece.vertices.max(axis=0) - piece.vertices.min(axis=0)).max()) for piece in pieces)
