"""PartNet-Mobility: mobility_v2.json, result.json, textured_objs/, meta.json."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.core.joint import Joint
from kinmo.core.mobility import Body, Mobility, has_cycle
from kinmo.core.shape import Shape, bounds_of
from kinmo.core.wording import clean_text
from kinmo.io.readers.json_field import JsonField
from kinmo.io.readers.part_hierarchy import Hierarchy
from kinmo.io.readers.partnet_annotation import MOBILITY_FILE, annotation_files, read_hierarchy, read_meta
from kinmo.io.readers.partnet_mobility_joints import checked_against_bounds, read_joint
from kinmo.io.readers.reader import Reader
from kinmo.io.readers.untrusted_files import read_json

PARTNET_MOBILITY = "partnet_mobility"
_FIRST_OWN_ID = 100_000
"""First id of shapes that do not come from PartNet. Smaller ids are those of PartNet annotations."""


def read_partnet_mobility(folder: Path) -> Shape:
    """Read the shape in a folder, with its mobility. Raises InputError if the files cannot be used."""
    folder = Path(folder)
    hierarchy = read_hierarchy(folder, folder / "result.json")
    repairs: list[str] = []
    mobility = _read_mobility(folder, hierarchy, repairs)
    meta = read_meta(folder, hierarchy.parts[0].name)
    name = folder.resolve().name
    comes_from_partnet = not (name.isdecimal() and int(name[:12]) >= _FIRST_OWN_ID)
    return Shape(
        id=clean_text(name),
        category=meta.category,
        parts=hierarchy.parts,
        source=folder,
        layout=PARTNET_MOBILITY,
        mobility=mobility,
        partnet_id=meta.annotation if comes_from_partnet else None,
        repairs=(*meta.repairs, *hierarchy.repairs, *repairs),
    )


READER = Reader(
    PARTNET_MOBILITY, read_partnet_mobility, annotation_files, is_shape_folder=lambda folder, names: MOBILITY_FILE in names
)


@dataclass(eq=False)
class _Draft:
    """A body under construction. `entry` is its JSON object, `joint_name` its field `joint`."""

    entry: JsonField
    id: int
    name: str
    joint_name: str
    repairs: list[str]
    joint: Joint | None = None
    parent: _Draft | None = None
    leaves: list[int] = field(default_factory=list)

    def __str__(self) -> str:
        return f"body {self.id} ({self.name})"

    def note_joint(self, repair: str) -> None:
        """Record a repair of the joint."""
        self.repairs.append(f"joint of {self}: {repair}")


def _read_mobility(folder: Path, hierarchy: Hierarchy, repairs: list[str]) -> Mobility:
    """Read the bodies and joints of mobility_v2.json. `repairs` receives one line for each problem that is repaired.

    The *base* is the rigid root body with the most leaves. It gets the leaves that no body owns. Joints without a parent are
    attached to it. Bodies without geometry are skipped, and their children move up to their parents.
    """
    file = folder / MOBILITY_FILE
    entries = read_json(file, folder).items()
    if not entries:
        raise InputError(file, "expected a list of bodies")
    drafts = []
    for entry in entries:
        draft = _Draft(entry, entry["id"].integer(), entry["name"].text(""), entry["joint"].text(""), repairs)
        draft.joint = read_joint(entry, draft.note_joint)
        drafts.append(draft)
    _connect(drafts)
    _assign_leaves(drafts, hierarchy)
    low, high = bounds_of(part.mesh for part in hierarchy.parts if part.mesh is not None)
    for draft in drafts:
        if draft.joint is not None:
            origin = draft.entry["jointData"]["axis"]["origin"]
            draft.joint = checked_against_bounds(draft.joint, origin.fail, low, high, draft.note_joint)
    drafts = _without_empty(drafts, repairs)
    _complete(drafts, hierarchy, repairs)
    bodies = (
        Body(d.id, d.name, tuple(sorted(d.leaves)), parent, d.joint) for d, parent in zip(drafts, _parents(drafts), strict=True)
    )
    return Mobility(tuple(bodies), frozenset(leaf for d in drafts if d.joint_name == "junk" for leaf in d.leaves))


def _connect(drafts: list[_Draft]) -> None:
    """Set the parents of all drafts."""
    by_id: dict[int, _Draft] = {}
    for draft in drafts:
        if by_id.setdefault(draft.id, draft) is not draft:
            raise draft.entry["id"].fail(f"body {draft.id} occurs twice")
    for draft in drafts:
        parent = draft.entry["parent"].integer(-1)
        if parent != -1:
            if parent not in by_id:
                raise draft.entry["parent"].fail(f"there is no body {parent}")
            draft.parent = by_id[parent]
    if has_cycle(_parents(drafts)):
        raise InputError(drafts[0].entry.where, "the parents of the bodies form a cycle", "parent")
    for draft in drafts:
        if draft.joint_name == "free":
            draft.parent = None


def _parents(drafts: list[_Draft]) -> list[int | None]:
    """Index of the parent of each draft."""
    place = {draft: index for index, draft in enumerate(drafts)}
    return [None if draft.parent is None else place[draft.parent] for draft in drafts]


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
    repairs += [f"{draft} has no geometry: skipped" for draft in drafts if not draft.leaves]
    for draft in drafts:
        while draft.parent is not None and not draft.parent.leaves:
            draft.parent = draft.parent.parent
    return [draft for draft in drafts if draft.leaves]


def _complete(drafts: list[_Draft], hierarchy: Hierarchy, repairs: list[str]) -> None:
    """Give every leaf a body and every joint a parent."""
    owned = {leaf for draft in drafts for leaf in draft.leaves}
    orphans = [index for index, part in enumerate(hierarchy.parts) if part.is_leaf and index not in owned]
    rigid_roots = [draft for draft in drafts if draft.joint is None and draft.parent is None and draft.joint_name != "junk"]
    base = max(rigid_roots, key=lambda draft: len(draft.leaves), default=None)
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
                draft.parent = base
                repairs.append(f"{draft} has a joint, but no parent: attached to {base}")
