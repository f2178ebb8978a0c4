"""A prediction with the corrections of a person: grouping first, then joints, parents and names."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from kinmo.core.corrected_joint import corrected_joint, override_estimate
from kinmo.core.joint import Joint
from kinmo.core.mobility import Body, Mobility, has_cycle
from kinmo.core.motion_types import CoarseType
from kinmo.core.overrides import BodyOverride, Overrides, Reference
from kinmo.core.references import ReferenceProblem, body_labels, find_body, find_leaves
from kinmo.core.shape import Shape
from kinmo.core.shape_estimate import OVERRIDE, Correction, JointEstimate, ShapeEstimate
from kinmo.core.wording import clean_text


def corrected_estimate(shape: Shape, estimate: ShapeEstimate, overrides: Overrides) -> ShapeEstimate:
    """The prediction as a person corrected it.

    Corrections apply to the prediction of the method: an earlier correction of `estimate` is replaced. Names and numbers mean
    the bodies as predicted. Corrected joints have the score 1, and all predicted ones as alternatives. A body that loses all
    its parts is dropped, and its children move up to its parent, or else to the largest resting body. Parts that a body gives
    up go to its parent.

    Args:
        shape: The shape.
        estimate: A prediction for it.
        overrides: The corrections.

    Returns:
        The corrected prediction. Its `correction` has the prediction, the overrides, and a note for each consequence.

    Raises:
        InputError: The overrides name something that does not exist, contradict each other, or give no tree of bodies.
    """
    predicted = estimate.predicted
    bodies = _Bodies(shape, predicted, overrides)
    bodies.regroup()
    bodies.correct_joints()
    bodies.attach()
    return bodies.estimate()


@dataclass(eq=False)
class _Draft:
    """A body under correction."""

    number: int
    name: str
    leaves: list[int]
    parent: _Draft | None
    joint: Joint | None
    estimates: tuple[JointEstimate, ...]
    gnn_estimate: JointEstimate | None
    override: BodyOverride | None = None
    is_new: bool = False
    is_dropped: bool = False
    is_orphan: bool = False  # its predicted parent was dropped, and so was every body above that

    @property
    def has_fixed_parts(self) -> bool:
        """True if a person listed its parts."""
        return self.override is not None and self.override.parts is not None


@dataclass(eq=False)
class _Bodies:
    """All bodies of a prediction under correction."""

    shape: Shape
    predicted: ShapeEstimate
    overrides: Overrides
    drafts: list[_Draft] = field(init=False)
    new: dict[str, _Draft] = field(init=False)
    notes: list[str] = field(init=False, default_factory=list)

    labels: dict[int, str] = field(init=False)  # names of the bodies for messages, by their numbers

    def __post_init__(self) -> None:
        mobility = self.predicted.mobility
        gnn_estimates = self.predicted.gnn_estimates or (None,) * len(mobility.bodies)
        ranked = zip(mobility.bodies, self.predicted.estimates, gnn_estimates, strict=True)
        self.drafts = [
            _Draft(body.id, body.name, list(body.leaves), None, body.joint, estimates, network)
            for body, estimates, network in ranked
        ]
        for draft, body in zip(self.drafts, mobility.bodies, strict=True):
            draft.parent = None if body.parent is None else self.drafts[body.parent]
        for key, override in self.overrides.bodies.items():
            draft = self._predicted_draft(key, override, "")
            if draft.override is not None:
                raise override.fail("", f"is the same body as {draft.override.path}: write one table for it")
            draft.override = override
        number = max((draft.number for draft in self.drafts), default=-1)
        names = {draft.name for draft in self.drafts}
        self.new = {}
        nothing = JointEstimate(None, CoarseType.NONE, 0.0, source=OVERRIDE) if self.predicted.gnn_estimates else None
        for place, (name, override) in enumerate(self.overrides.new_bodies.items(), 1):
            if name in names:
                raise override.fail("", f"there is a body of this name: correct it below [bodies.{clean_text(name)}]")
            self.new[name] = _Draft(number + place, name, [], None, None, (), nothing, override, True)
        self.drafts += self.new.values()
        self.labels = body_labels({draft.number: draft.name for draft in self.drafts})

    def regroup(self) -> None:
        """Move parts between bodies, and drop the bodies that have none left."""
        before = {leaf: draft for draft in self.drafts for leaf in draft.leaves}
        claims: dict[int, _Draft] = {}
        for draft in self.drafts:
            for leaf in self._claimed(draft):
                other = claims.setdefault(leaf, draft)
                if other is not draft and draft.override is not None:
                    raise draft.override.fail(
                        "parts", f"{self._part(leaf)} is listed for {self._label(other)} too: list it once"
                    )
        had_parts = {draft for draft in self.drafts if draft.leaves}
        for leaf, old in before.items():
            owner = claims.get(leaf, old)
            if owner is old and leaf not in claims and old.has_fixed_parts:
                owner = self._heir(old, leaf)
                self.notes.append(f"{self._part(leaf)} of {self._label(old)} goes to {self._label(owner)}")
            if owner is not old:
                old.leaves.remove(leaf)
                owner.leaves.append(leaf)
        for draft in had_parts:
            draft.is_dropped = not draft.leaves
        for draft in self.drafts:
            draft.leaves.sort()
            if draft.is_dropped:
                corrections = draft.override is not None and (draft.override.joint_fields or draft.override.name)
                self.notes.append(
                    f"{self._label(draft)} has no part left: dropped{', with its corrections' * bool(corrections)}"
                )
            while draft.parent is not None and draft.parent.is_dropped:
                draft.parent = draft.parent.parent
                draft.is_orphan = draft.parent is None

    def correct_joints(self) -> None:
        """Give every body that a person corrected its joint and its name."""
        for draft in self._present():
            override = draft.override
            if override is None:
                continue
            draft.name = draft.name if override.name is None else override.name
            if override.joint_fields and not draft.leaves:
                raise override.fail(next(iter(override.joint_fields)), "the body has no parts, so it has no joint")
            if override.joint_fields:
                draft.joint = corrected_joint(override, draft.joint, draft.estimates, self.shape, draft.leaves)
                draft.estimates = (override_estimate(draft.joint), *draft.estimates)

    def attach(self) -> None:
        """Give every body its parent."""
        present = list(self._present())
        for draft in present:
            if draft.override is not None and draft.override.parent is not None:
                draft.parent = self._parent(draft.override, draft.override.parent)
        base = self._base(present)
        for draft in present:
            corrected = draft.override is not None and (draft.joint is not None or draft.is_new)
            if draft.parent is None and (corrected or (draft.is_orphan and draft.joint is not None)):
                if base is None and draft.override is not None:
                    raise draft.override.fail("parent", "needed, because no body is left that rests")
                draft.parent = base
        if has_cycle(self._parents(present)):
            loop = next(loop for draft in present if (loop := _loop(draft)))
            override = next(each.override for each in loop if each.override is not None and each.override.parent is not None)
            names = " -> ".join(self._label(each) for each in [*loop, loop[0]])
            raise override.fail("parent", f"the parents form a cycle: {names}")

    def estimate(self) -> ShapeEstimate:
        """The corrected prediction."""
        present = list(self._present())
        bodies = (
            Body(draft.number, draft.name, tuple(draft.leaves), parent, draft.joint)
            for draft, parent in zip(present, self._parents(present), strict=True)
        )
        predicted = self.predicted
        return ShapeEstimate(
            predicted.shape_id,
            predicted.category,
            Mobility(tuple(bodies), predicted.mobility.junk),
            tuple(draft.estimates for draft in present),
            tuple(draft.gnn_estimate for draft in present if draft.gnn_estimate is not None),
            predicted.method,
            predicted.missed_motion_probability,
            Correction(predicted, self.overrides.table, tuple(self.notes)),
        )

    def _present(self) -> Iterator[_Draft]:
        return (draft for draft in self.drafts if not draft.is_dropped)

    def _parents(self, present: Sequence[_Draft]) -> list[int | None]:
        place = {draft: index for index, draft in enumerate(present)}
        return [None if draft.parent is None else place[draft.parent] for draft in present]

    def _base(self, drafts: Sequence[_Draft]) -> _Draft | None:
        """The resting root body with the most parts. None if there is none."""
        junk = self.predicted.mobility.junk
        roots = [draft for draft in drafts if draft.parent is None and draft.joint is None and not draft.is_new]
        real = [draft for draft in roots if not draft.leaves or not junk >= set(draft.leaves)]
        return max(real or roots, key=lambda draft: len(draft.leaves), default=None)

    def _claimed(self, draft: _Draft) -> Iterator[int]:
        """Leaves that a person lists for a body."""
        override = draft.override
        for place, reference in enumerate(() if override is None or override.parts is None else override.parts):
            assert override is not None
            try:
                yield from find_leaves(reference, self.shape)
            except ReferenceProblem as problem:
                raise override.fail(f"parts[{place}]", str(problem)) from None

    def _heir(self, draft: _Draft, leaf: int) -> _Draft:
        """The body that gets a part that `draft` gives up: the nearest one above it whose parts nobody listed, or the base."""
        above = draft.parent
        while above is not None and above.has_fixed_parts:
            above = above.parent
        found = above or self._base([each for each in self.drafts if not each.has_fixed_parts])
        if found is None:
            assert draft.override is not None
            raise draft.override.fail("parts", f"{self._part(leaf)} would belong to no body: list it for one")
        return found

    def _label(self, draft: _Draft) -> str:
        return self.labels[draft.number]

    def _part(self, leaf: int) -> str:
        part = self.shape.parts[leaf]
        return f"part {part.id} ({clean_text(part.name)})" if part.name.strip() else f"part {part.id}"

    def _predicted_draft(self, reference: Reference, override: BodyOverride, key: str) -> _Draft:
        """The body that a reference means. `key` is the field of `override` that has it; empty for the name of its table."""
        base = self._base(self.drafts)
        try:
            return self.drafts[find_body(reference, self.predicted.mobility, None if base is None else self.drafts.index(base))]
        except ReferenceProblem as problem:
            raise override.fail(key, str(problem)) from None

    def _parent(self, override: BodyOverride, reference: Reference) -> _Draft:
        """The body that a correction names as parent: a new one, a predicted one, or one by its new name."""
        parent = self.new.get(reference) if isinstance(reference, str) else None
        if parent is None:
            renamed = [each for each in self.drafts if each.override is not None and each.override.name == reference]
            is_predicted = any(body.name == reference for body in self.predicted.mobility.bodies)
            parent = (
                renamed[0] if len(renamed) == 1 and not is_predicted else self._predicted_draft(reference, override, "parent")
            )
        if parent.is_dropped:
            raise override.fail("parent", f"{self._label(parent)} has no part left: name another body")
        return parent


def _loop(draft: _Draft) -> list[_Draft] | None:
    """The cycle of parents that a body is part of. None if it is part of none."""
    above, found = draft.parent, [draft]
    while above is not None and above not in found:
        found.append(above)
        above = above.parent
    return found if above is draft else None
