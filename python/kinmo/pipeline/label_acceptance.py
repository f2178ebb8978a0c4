"""Acceptance of predictions as pseudo labels (paper, section 3.3, last paragraph), and the report of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from kinmo.core.shape_estimate import ShapeEstimate

SCORE_STEPS = tuple(round(0.1 * step, 1) for step in range(10))  # thresholds of the columns in the acceptance report


@dataclass(frozen=True)
class ScoredJoint:
    """A predicted joint: the name of the `body` that it moves, its motion `type`, and its `score` in [0, 1]."""

    body: str
    type: str
    score: float


@dataclass(frozen=True)
class LabelDecision:
    """Decision whether the prediction for a shape becomes its pseudo label."""

    shape_id: str
    layout: str
    category: str
    joints: tuple[ScoredJoint, ...] = ()
    refusal: str = ""  # why the shape gets no label; empty if it gets one
    doubt: float = 0.0  # largest probability that a resting part moves
    threshold: float = 0.0  # score that every joint had to exceed

    @property
    def is_accepted(self) -> bool:
        """True if the shape gets a pseudo label."""
        return not self.refusal

    @property
    def score(self) -> float | None:
        """Score of the worst joint; None without joints."""
        return min((joint.score for joint in self.joints), default=None)


def decide(prediction: ShapeEstimate, layout: str, threshold: float, max_doubt: float = 1.0) -> LabelDecision:
    """Accept or refuse a prediction as a pseudo label.

    A shape is accepted as a whole: a label that lacks a joint would teach that the part does not move. Every joint must score
    more than the threshold (tau in the paper, 0.6), and no resting part may move with a probability above `max_doubt`.
    """
    doubt = float(prediction.missed_motion_probability)
    moving = ((body.name, prediction.estimates[index][0]) for index, body in prediction.mobility.movable())
    joints = tuple(ScoredJoint(name, best.type.name, float(best.score)) for name, best in moving)
    refusal = ""
    if not joints:
        refusal = "no moving part was found"
    elif (worst := min(joints, key=lambda joint: joint.score)).score <= threshold:
        refusal = f"a joint scores no more than {threshold:g}: {worst.type}"
    elif doubt > max_doubt:
        refusal = f"a resting part moves with a probability above {max_doubt:g}"
    return LabelDecision(prediction.shape_id, layout, prediction.category, joints, refusal, doubt, threshold)


def decision_from_data(data: Mapping[str, Any]) -> LabelDecision:
    """The decision that `dataclasses.asdict` took apart. Raises TypeError or KeyError for anything else."""
    return LabelDecision(**{**data, "joints": tuple(ScoredJoint(**joint) for joint in data["joints"])})


@dataclass(frozen=True)
class AcceptanceCounts:
    """Numbers of shapes and joints of one group; `above[i]` counts joints that score more than `SCORE_STEPS[i]`."""

    shapes: int
    accepted_shapes: int
    joints: int
    accepted_joints: int
    above: tuple[int, ...]


def count_accepted(decisions: Iterable[LabelDecision]) -> AcceptanceCounts:
    """Count the shapes and joints of a group of decisions."""
    group = list(decisions)
    accepted = [len(decision.joints) for decision in group if decision.is_accepted]
    scores = [joint.score for decision in group for joint in decision.joints]
    above = tuple(sum(score > step for score in scores) for step in SCORE_STEPS)
    return AcceptanceCounts(len(group), len(accepted), len(scores), sum(accepted), above)


def count_by_type(decisions: Sequence[LabelDecision]) -> dict[str, AcceptanceCounts]:
    """Counts by motion type; the shapes of a type are those with such a joint."""
    counts = {}
    for name in sorted({joint.type for decision in decisions for joint in decision.joints}):
        own = (replace(d, joints=tuple(joint for joint in d.joints if joint.type == name)) for d in decisions)
        counts[name] = count_accepted(decision for decision in own if decision.joints)
    return counts


def acceptance_report(
    decisions: Sequence[LabelDecision], method: str, copies: int, outdated: Sequence[str] = ()
) -> dict[str, Any]:
    """The report as plain data: `text`, `ways` (thresholds and method), `copies`, `tables` and `refused` (ids by reason).

    `copies` is the number of copies of labelled shapes, which are not labelled. The labels of `outdated` categories come from
    other networks or files than the current ones.
    """
    ways = sorted({f"all joints above {decision.threshold:g}, by {method}" for decision in decisions})
    whole = count_accepted(decisions)
    categories = sorted({decision.category for decision in decisions})
    by_category = {name: count_accepted(d for d in decisions if d.category == name) for name in categories} | {"all": whole}
    reasons: dict[str, list[str]] = {}
    for decision in decisions:
        if not decision.is_accepted:
            reasons.setdefault(decision.refusal, []).append(decision.shape_id)
    text = (
        f"Accepted {whole.accepted_shapes} of {whole.shapes} shapes ({'; or '.join(ways) or 'there are none'}) and "
        f"{whole.accepted_joints} of {whole.joints} joints; skipped {copies} copies of labelled shapes."
    )
    if outdated:
        text += f" Labels of {', '.join(outdated)} are outdated: run kinmo pseudo-label to update them."
    refused = [[reason, str(len(ids)), ids[0]] for reason, ids in sorted(reasons.items(), key=lambda item: -len(item[1]))]
    refusals = {"caption": "Refused shapes", "header": ["reason", "shapes", "for example"], "rows": refused}
    by_type = _table("Pseudo labels by motion type", "type", count_by_type(decisions))
    tables = [_table("Pseudo labels by category", "category", by_category), by_type, refusals]
    return {"text": text, "ways": ways, "copies": copies, "tables": tables, "refused": dict(sorted(reasons.items()))}


def _table(caption: str, what: str, groups: Mapping[str, AcceptanceCounts]) -> dict[str, Any]:
    header = [what, "shapes", "accepted", "joints", "accepted joints", *(f"> {step:g}" for step in SCORE_STEPS)]
    rows = [
        [name, *map(str, (own.shapes, own.accepted_shapes, own.joints, own.accepted_joints, *own.above))]
        for name, own in groups.items()
    ]
    note = "The columns on the right count joints with a higher score."
    return {"caption": caption, "header": header, "rows": rows, "note": note}
