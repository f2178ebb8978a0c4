"""Acceptance of predictions as pseudo labels (paper, section 3.3, last paragraph), and the report of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from kinmo.core.shape_estimate import ShapeEstimate

SCORE_STEPS = tuple(round(0.1 * step, 1) for step in range(10))
"""Thresholds of the columns in the acceptance report."""


@dataclass(frozen=True)
class ScoredJoint:
    """A predicted joint: the name of the `body` that it moves, its motion `type`, and its `score` in [0, 1]."""

    body: str
    type: str
    score: float


@dataclass(frozen=True)
class LabelDecision:
    """Decision whether the prediction for a shape becomes its pseudo label.

    Attributes:
        shape_id: Id of the shape.
        layout: Dataset layout of the shape.
        category: Category of the shape.
        joints: The predicted joints.
        refusal: The reason why it gets no label; empty if it gets one.
        doubt: Largest probability that a resting part moves (`Prediction.doubt`).
        threshold: Score that every joint had to exceed.
    """

    shape_id: str
    layout: str
    category: str
    joints: tuple[ScoredJoint, ...] = ()
    refusal: str = ""
    doubt: float = 0.0
    threshold: float = 0.0

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

    A shape is accepted as a whole: a label that lacks a joint would teach that the part does not move.

    Args:
        prediction: The prediction.
        layout: Dataset layout of the shape.
        threshold: Score that every joint must exceed (tau in the paper, 0.6).
        max_doubt: Largest accepted probability that a resting part moves.

    Returns:
        The decision, with the reason of a refusal.
    """
    joints = []
    for index, body in prediction.mobility.movable():
        best = prediction.estimates[index][0]
        joints.append(ScoredJoint(body.name, best.type.name, float(best.score)))
    refusal = ""
    if not joints:
        refusal = "no moving part was found"
    elif (worst := min(joints, key=lambda joint: joint.score)).score <= threshold:
        refusal = f"a joint scores no more than {threshold:g}: {worst.type}"
    elif prediction.missed_motion_probability > max_doubt:
        refusal = f"a resting part moves with a probability above {max_doubt:g}"
    doubt = float(prediction.missed_motion_probability)
    return LabelDecision(prediction.shape_id, layout, prediction.category, tuple(joints), refusal, doubt, threshold)


def decision_to_data(decision: LabelDecision) -> dict[str, Any]:
    """A decision as plain data."""
    return asdict(decision)


def decision_from_data(data: Mapping[str, Any]) -> LabelDecision:
    """The decision that `decision_to_data` took apart. Raises TypeError or KeyError for anything else."""
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
    accepted = [decision for decision in group if decision.is_accepted]
    scores = [joint.score for decision in group for joint in decision.joints]
    return AcceptanceCounts(
        len(group),
        len(accepted),
        len(scores),
        sum(len(decision.joints) for decision in accepted),
        tuple(sum(score > step for score in scores) for step in SCORE_STEPS),
    )


def count_by_type(decisions: Iterable[LabelDecision]) -> dict[str, AcceptanceCounts]:
    """Counts by motion type; the shapes of a type are those with such a joint."""
    group = list(decisions)
    names = sorted({joint.type for decision in group for joint in decision.joints})
    reduced = {name: [_only(decision, name) for decision in group] for name in names}
    return {name: count_accepted(decision for decision in own if decision.joints) for name, own in reduced.items()}


def _only(decision: LabelDecision, motion_type: str) -> LabelDecision:
    return replace(decision, joints=tuple(joint for joint in decision.joints if joint.type == motion_type))


def acceptance_report(
    decisions: Sequence[LabelDecision], method: str, copies: int, outdated: Sequence[str] = ()
) -> dict[str, Any]:
    """The acceptance report as plain data.

    Args:
        decisions: The decisions on all unlabelled shapes.
        method: The method that predicted.
        copies: Number of copies of labelled shapes, which are not labelled.
        outdated: Categories whose labels come from other networks or files than the current ones.

    Returns:
        `text`, `ways` (thresholds and method), `copies`, `tables` (caption, header, rows) and `refused` (ids by reason).
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
    refused = sorted(reasons.items(), key=lambda item: -len(item[1]))
    return {
        "text": text,
        "ways": ways,
        "copies": copies,
        "tables": [
            _table("Pseudo labels by category", "category", by_category),
            _table("Pseudo labels by motion type", "type", count_by_type(decisions)),
            {
                "caption": "Refused shapes",
                "header": ["reason", "shapes", "for example"],
                "rows": [[reason, str(len(ids)), ids[0]] for reason, ids in refused],
            },
        ],
        "refused": dict(sorted(reasons.items())),
    }


def _table(caption: str, what: str, groups: Mapping[str, AcceptanceCounts]) -> dict[str, Any]:
    header = [what, "shapes", "accepted", "joints", "accepted joints", *(f"> {step:g}" for step in SCORE_STEPS)]
    rows = [
        [name, *map(str, (own.shapes, own.accepted_shapes, own.joints, own.accepted_joints, *own.above))]
        for name, own in groups.items()
    ]
    note = "The columns on the right count joints with a higher score."
    return {"caption": caption, "header": header, "rows": rows, "note": note}
