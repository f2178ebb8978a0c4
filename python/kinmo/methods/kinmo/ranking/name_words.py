"""Hashed words of the names of parts and categories, as the ranking networks read them."""

from __future__ import annotations

import zlib
from collections.abc import Sequence

from kinmo.core.name_words import tell_apart, words_of
from kinmo.features.prepared_shape import PreparedShape

WORD_BUCKETS = 1024
"""Number of buckets that words are hashed to."""


def hash_words(role: str, text: str) -> list[int]:
    """Buckets of the words of a name; the same word gets another bucket in another role, such as "part"."""
    return [zlib.crc32(f"{role}:{word}".encode()) % WORD_BUCKETS for word in words_of(text)]


def has_names(shape: PreparedShape) -> bool:
    """True if names tell the leaves apart."""
    return tell_apart(shape.part_names[leaf] for leaf in shape.leaves)


def maximal_nodes(shape: PreparedShape, leaves: Sequence[int]) -> list[int]:
    """The highest nodes of the hierarchy whose leaves all are among `leaves` (positions in `shape.leaves`)."""
    wanted = set(leaves)
    inside = [set(below) <= wanted for below in shape.leaves_below]
    return [n for n, parent in enumerate(shape.parents) if inside[n] and (parent < 0 or not inside[parent])]


def group_words(shape: PreparedShape, leaves: Sequence[int], *, sees_hierarchy: bool = True) -> tuple[int, ...]:
    """Hashed words of a group of leaves: the names of its highest nodes, of its leaves, and of the nodes above it.

    Without the hierarchy, the leaves are the highest nodes.
    """
    own = [shape.leaves[leaf] for leaf in leaves]
    top = maximal_nodes(shape, leaves) if sees_hierarchy else own
    words = [w for n in top for w in hash_words("part", shape.part_names[n])]
    words += [w for n in own for w in hash_words("leaf", shape.part_names[n])]
    above = {shape.parents[n] for n in top if shape.parents[n] > 0} if sees_hierarchy else set()
    words += [w for n in sorted(above) for w in hash_words("inside", shape.part_names[n])]
    return tuple(words)


def category_words(shape: PreparedShape) -> tuple[int, ...]:
    """Hashed words of the shape's category."""
    return tuple(hash_words("category", shape.category))
