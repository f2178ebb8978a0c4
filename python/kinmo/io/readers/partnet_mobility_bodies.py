"""Bodies of mobility_v2.json, joined to a mobility tree."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.core.joint import Joint
from kinmo.core.mobility import Body, Mobility, has_cycle
from kinmo.core.shape import bounds_of
from kinmo.io.readers.json_field import JsonField
from kinmo.io.readers.part_hierarchy import Hierarchy
from kinmo.io.readers.partnet_annotation import MOBILITY_FILE
from kinmo.io.readers.partnet_mobility_joints import checked_against_bounds, read_joint
from kinmo.io.readers.untrusted_files import read_json


@dataclass(eq=False)
class _Draft:
    """A body under construction. `entry` is its JSON object, `joint_name` its field `joint`, `parent` an index of drafts."""

    entry: JsonField
    id: int
    name: str
    joint_name: str
    repairs: list[str]
    joint: Joint | None = None
    parent: int | None = None
    leaves: list[int] = field(default_factory=list)

    def __str__(self) -> str:
        return f"body {self.id} ({self.name})"

    def note_joint(self, repair: str) -> None:
        """Record a repair of the joint."""
        self.repairs.append(f"joint of {self}: {repair}")

    @property
    def can_be_base(self) -> bool:
        return self.joint is None and self.parent is None and self.joint_name != "junk"


def read_mobility(folder: Path, hierarchy: Hierarchy, repairs: list[str]) -> Mobility:
    """Read the bodies and joints of mobility_v2.json.

    The *base* is the rigid root body with the most leaves. It gets the leaves that no body owns. Joints without a parent are
    attached to it. Bodies without geometry are skipped, and their children move up to their parents.

    Args:
        folder: the folder of the shape.
        hierarchy: the parts of the shape.
        repairs: receives one line for each problem that is repaired.

    Returns:
        The mobility tree.

    Raises:
        InputError: the file cannot be used. The message names the field.
    """
    file = folder / MOBILITY_FILE
    entries = JsonField(file, read_json(file, folder)).items()
    if not entries:
        raise InputError(file, "expected a list of bodies")
    drafts = [_draft(entry, repairs) for entry in entries]
    _connect(drafts)
    _assign_leaves(drafts, hierarchy)
    low, high = bounds_of(part.mesh for part in hierarchy.parts if part.mesh is not None)
    for draft in drafts:
        if draft.joint is not None:
            draft.joint = checked_against_bounds(draft.joint, draft.entry, low, high, draft.note_joint)
    drafts = _without_empty(drafts, repairs)
    _complete(drafts, hierarchy, repairs)
    bodies = tuple(Body(d.id, d.name, tuple(sorted(d.leaves)), d.parent, d.joint) for d in drafts)
    return Mobility(bodies, frozenset(leaf for d in drafts if d.joint_name == "junk" for leaf in d.leaves))


def _draft(entry: JsonField, repairs: list[str]) -> _Draft:
    draft = _Draft(entry, entry["id"].integer(), entry["name"].text(""), entry["joint"].text(""), repairs)
    draft.joint = read_joint(entry, draft.note_joint)
    return draft


def _connect(drafts: list[_Draft]) -> None:
    """Set the parents of all drafts."""
    index_of: dict[int, int] = {}
    for index, draft in enumerate(drafts):
        if draft.id in index_of:
            raise draft.entry["id"].fail(f"body {draft.id} occurs twice")
        index_of[draft.id] = index
    for draft in drafts:
        parent = draft.entry["parent"].integer(-1)
        if parent != -1:
            if parent not in index_of:
                raise draft.entry["parent"].fail(f"there is no body {parent}")
            draft.parent = index_of[parent]
    if has_cycle([draft.parent for draft in drafts]):
        raise InputError(drafts[0].entry.where, "the parents of the bodies form a cycle", "parent")
    for draft in drafts:
        if draft.joint_name == "free":
            draft.parent = None


def _assign_leaves(drafts: list[_Draft], hierarchy: Hierarchy) -> None:
    owner: dict[int, _Draft] = {}
    for draft in drafts:
        for part in draft.entry["parts"].items():
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
    repairs += [f"{draft} has no geometry: skipped" for draft in drafts if not draft.leaves]
    for index in kept:
        parent = drafts[index].parent
        while parent is not None and parent not in place:
            parent = drafts[parent].parent
        drafts[index].parent = None if parent is None else place[parent]
    return [drafts[index] for index in kept]


def _complete(drafts: list[_Draft], hierarchy: Hierarchy, repairs: list[str]) -> None:
    """Give every leaf a body and every joint a parent."""
    owned = {leaf for draft in drafts for leaf in draft.leaves}
    orphans = [index for index, part in enumerate(hierarchy.parts) if part.is_leaf and index not in owned]
    bases = [draft for draft in drafts if draft.can_be_base]
    base = max(bases, key=lambda draft: len(draft.leaves), default=None)
    if orphans:
        if base is None:
            number = max((draft.id for draft in drafts), default=-1) + 1
            base = _Draft(JsonField(Path(MOBILITY_FILE), None), number, "base", "static", repairs)
            drafts.append(base)
        base.leaves += orphans
        names = ", ".join(str(hierarchy.parts[leaf].id) for leaf in orphans)
        repairs.append(f"no body owns the leaves {names}: given to {base}")
    for draft in drafts:
        if draft.joint is not None and draft.parent is None:
            if base is None:
                draft.joint = None
                repairs.append(f"{draft} has a joint, but there is no body to attach it to: joint dropped")
            else:
                draft.parent = drafts.index(base)
                repairs.append(f"{draft} has a joint, but no parent: attached to {base}")
