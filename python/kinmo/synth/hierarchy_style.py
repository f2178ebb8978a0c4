"""Hierarchy styles of annotators: nested as in PartNet or one leaf per body, with parts grouped well or badly.

Both kinds are about equally common among real objects. No single node is the moving part for a tenth of real joints.
"""

from __future__ import annotations

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.synth_object import JointType, Link, Node, SynthObject

FLAT_SHARE = 0.15
"""Share of nested objects that are written with one leaf per link, besides families that always are."""
SPLIT_SHARE = 0.09
"""Share of moving links whose parts end up under different nodes."""
WRAPPED_SHARE = 0.03
"""Share of leaves that get an inner node with a single child above them."""
JUNK_SHARE = 0.1
"""Share of objects in which one leaf is marked as junk."""


def is_nested(obj: SynthObject) -> bool:
    """True if the hierarchy has inner nodes besides the root, as PartNet's annotations have."""
    return any(child.children for child in obj.root.children)


def apply_hierarchy_style(obj: SynthObject, draw: Draw) -> None:
    """Rearrange an object's hierarchy at random, in place. Links keep exactly their geometry."""
    if is_nested(obj) and draw.chance(FLAT_SHARE):
        flatten_hierarchy(obj, draw)
    for link in obj.links:
        if link.motion is not None and draw.chance(SPLIT_SHARE):
            _split_link(obj, link, draw)
    for node in list(obj.root.walk()):
        for index, child in enumerate(node.children):
            if not child.children and draw.chance(WRAPPED_SHARE):
                _wrap_leaf(obj, node, index)
    if draw.chance(JUNK_SHARE):
        _mark_junk(obj, draw)


def flatten_hierarchy(obj: SynthObject, draw: Draw) -> None:
    """Make one leaf of each link, directly below the root, in place. Moving links come first."""
    root = Node(obj.category)
    moving = [link for link in obj.links if link.motion is not None]
    standing = [link for link in obj.links if link.motion is None]
    for link in moving + standing:
        pieces = [piece for leaf in link.leaves() for piece in leaf.pieces]
        name = link.leaf_name or (link.name if link.motion is not None else "base_body")
        link.nodes = [root.add(name, *pieces)]
    obj.root = root
    if draw.chance(0.4):
        shuffled = sorted(range(len(moving)), key=lambda _: draw.integer(0, 1 << 30))
        root.children[: len(moving)] = [root.children[i] for i in shuffled]


def _split_link(obj: SynthObject, link: Link, draw: Draw) -> None:
    """Put a part of a link under another node than the rest, so that no single node is the moving part."""
    parents = {child: node for node in obj.root.walk() for child in node.children}
    if len(link.nodes) != 1 or link.nodes[0] not in parents:
        return
    node, above = link.nodes[0], parents[link.nodes[0]]
    if node.children:
        above.children[above.children.index(node) : above.children.index(node) + 1] = node.children
        link.nodes = list(node.children)
    elif len(node.pieces) > 1:
        count = draw.integer(1, max(1, len(node.pieces) // 2))
        outlier = Node(draw.pick(["outlier", "other", "handle"], [3, 1, 1]), pieces=node.pieces[-count:])
        node.pieces = node.pieces[:-count]
        obj.root.children.append(outlier)
        link.nodes.append(outlier)


def _wrap_leaf(obj: SynthObject, above: Node, index: int) -> None:
    """Put a leaf below an inner node of its own, as "other" often has a single "other_leaf"."""
    leaf = above.children[index]
    name = "other" if leaf.name.startswith("other") or above is obj.root else leaf.name
    above.children[index] = Node(name, [leaf])


def _mark_junk(obj: SynthObject, draw: Draw) -> None:
    """Mark the smallest leaf of a base with at least three leaves as junk."""
    for link in obj.links:
        spare = [leaf for leaf in link.leaves() if len(list(link.leaves())) > 2]
        if link.motion is None and link.parent is None and spare:
            leaf = min(spare, key=lambda node: _extent(node.pieces))
            link.nodes = [other for other in link.leaves() if other is not leaf]
            leaf.name = draw.pick(["other_leaf", "outlier", leaf.name], [2, 1, 1])
            obj.links.append(Link(leaf.name, [leaf], kind=JointType.JUNK))
            return


def _extent(pieces: list[Mesh]) -> float:
    """Largest side of any piece's bounding box."""
    return max(float((piece.vertices.max(axis=0) - piece.vertices.min(axis=0)).max()) for piece in pieces)
