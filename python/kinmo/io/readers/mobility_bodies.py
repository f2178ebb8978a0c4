"""The mobility tree of mobility_v2.json."""

from __future__ import annotations

from dataclasses import dataclass
from dataclasses import field as member
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.core.joint import Joint
from kinmo.core.mobility import Body, Mobility, has_cycle
from kinmo.core.shape import bounds_of
from kinmo.io.readers.field import Field
from kinmo.io.readers.mobility_joints import joint_near, read_joint
from kinmo.io.readers.part_hierarchy import Hierarchy
from kinmo.io.readers.untrusted_files import read_json


@dataclass(eq=False)
class _Draft:
    """A body while it is put together. `parent` is an index into the drafts."""

    id: int
    name: str
    word: str
    joint: Joint | None
    parent: int | None = None
    leaves: list[int] = member(default_factory=list)

    def __str__(self) -> str:
        return f"body {self.id} ({self.name})"

    @property
    def can_be_base(self) -> bool:
        return self.joint is None and self.parent is None and self.word != "junk"


def read_mobility(folder: Path, hierarchy: Hierarchy, repairs: list[str]) -> Mobility:
    """Bodies and joints of mobility_v2.json; what was mended is added to `repairs`.

    The *base* is the rigid body without parent that has most leaves. Leaves that no body owns join it, and it is what a joint
    without a parent moves against. A body without geometry is left out; what hangs on it hangs on its parent.
    """
    file = folder / "mobility_v2.json"
    entries = Field(file, read_json(file, folder)).items()
    if not entries:
        raise InputError(file, "expected a list of bodies")
    drafts = [_draft(entry, repairs) for entry in entries]
    _link(drafts, entries)
    _give_leaves(drafts, entries, hierarchy)
    low, high = bounds_of(part.mesh for part in hierarchy.parts if part.mesh is not None)
    for draft, entry in zip(drafts, entries, strict=True):
        if draft.joint is not None:
            draft.joint = joint_near(draft.joint, entry, low, high, repairs, str(draft))
    drafts = _without_empty(drafts, repairs)
    _complete(drafts, hierarchy, repairs)
    bodies = tuple(Body(d.id, d.name, tuple(sorted(d.leaves)), d.parent, d.joint) for d in drafts)
    return Mobility(bodies, frozenset(leaf for d in drafts if d.word == "junk" for leaf in d.leaves))


def _draft(entry: Field, repairs: list[str]) -> _Draft:
    identity, name = entry["id"].integer(), entry["name"].text("")
    joint = read_joint(entry, repairs, f"body {identity} ({name})")
    return _Draft(identity, name, entry["joint"].text(""), joint)


def _link(drafts: list[_Draft], entries: list[Field]) -> None:
    index_of: dict[int, int] = {}
    for index, draft in enumerate(drafts):
        if draft.id in index_of:
            raise entries[index]["id"].fail(f"body {draft.id} occurs twice")
        index_of[draft.id] = index
    for draft, entry in zip(drafts, entries, strict=True):
        parent = entry["parent"].integer() if not entry["parent"].is_absent else -1
        if parent != -1:
            if parent not in index_of:
                raise entry["parent"].fail(f"there is no body {parent}")
            draft.parent = index_of[parent]
    if has_cycle([draft.parent for draft in drafts]):
        raise InputError(entries[0].where, "the parents of the bodies form a cycle", "parent")
    for draft in drafts:
        if draft.word == "free":
            draft.parent = None


def _give_leaves(drafts: list[_Draft], entries: list[Field], hierarchy: Hierarchy) -> None:
    owner: dict[int, _Draft] = {}
    for draft, entry in zip(drafts, entries, strict=True):
        for part in entry["parts"].items():
            identity = part["id"].integer()
            if identity not in hierarchy.leaves_of:
                raise part["id"].fail(f"there is no part {identity} in result.json")
            for leaf in hierarchy.leaves_of[identity]:
                first = owner.setdefault(leaf, draft)
                if first is not draft:
                    raise part["id"].fail(f"leaf {hierarchy.parts[leaf].id} belongs to {first} and to {draft}")
    for leaf, draft in owner.items():
        draft.leaves.append(leaf)


def _without_empty(drafts: list[_Draft], repairs: list[str]) -> list[_Draft]:
    kept = [index for index, draft in enumerate(drafts) if draft.leaves]
    place = {index: position for position, index in enumerate(kept)}
    repairs += [f"{draft} has no geometry: left out" for draft in drafts if not draft.leaves]
    for index in kept:
        parent = drafts[index].parent
        while parent is not None and parent not in place:
            parent = drafts[parent].parent
        drafts[index].parent = None if parent is None else place[parent]
    return [drafts[index] for index in kept]


def _complete(drafts: list[_Draft], hierarchy: Hierarchy, repairs: list[str]) -> None:
    """Gives every leaf a body and every joint something to move against."""
    owned = {leaf for draft in drafts for leaf in draft.leaves}
    orphans = [index for index, part in enumerate(hierarchy.parts) if part.is_leaf and index not in owned]
    bases = [draft for draft in drafts if draft.can_be_base]
    base = max(bases, key=lambda draft: len(draft.leaves), default=None)
    if orphans:
        if base is None:
            base = _Draft(max((draft.id for draft in drafts), default=-1) + 1, "base", "static", None)
            drafts.append(base)
        base.leaves += orphans
        names = ", ".join(str(hierarchy.parts[leaf].id) for leaf in orphans)
        repairs.append(f"no body owns the leaves {names}: given to {base}")
    for draft in drafts:
        if draft.joint is not None and draft.parent is None:
            if base is None:
                draft.joint = None
                repairs.append(f"{draft} has a joint, but nothing to move against: joint left out")
            else:
                draft.parent = drafts.index(base)
                repairs.append(f"{draft} has a joint, but no parent: moves against {base}")
