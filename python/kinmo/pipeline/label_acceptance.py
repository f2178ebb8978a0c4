"""Which predictions are good enough to be taken as labels (paper, section 3.3, the last paragraph)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from kinmo.core.joint import CoarseType, MotionType
from kinmo.core.prediction import Prediction

STEPS = tuple(round(0.1 * step, 1) for step in range(10))
"""The thresholds of the acceptance report."""
ACCEPTANCE = "acceptance.json"
"""Name of that report, in the folder of the labels."""
LABELLING = "pseudo-label"
"""Name of the stage that gives labels, and of its record."""


@dataclass(frozen=True)
class JudgedJoint:
    """A joint of a prediction: the `body` it moves, its `type` and its `score` in [0, 1]."""

    body: str
    type: str
    score: float


@dataclass(frozen=True)
class Judgement:
    """What is thought of one shape, `doubt` as in `Prediction`. `refusal` says why it gets no label; empty if it gets one."""

    shape_id: str
    layout: str
    category: str
    joints: tuple[JudgedJoint, ...] = ()
    refusal: str = ""
    doubt: float = 0.0

    @property
    def is_accepted(self) -> bool:
        return not self.refusal

    @property
    def score(self) -> float | None:
        """That of the worst joint; None without joints."""
        return min((joint.score for joint in self.joints), default=None)


def judge(prediction: Prediction, layout: str, threshold: float, doubt: float = 1.0) -> Judgement:
    """Accept a shape if every one of its joints scores more than `threshold` (the paper's tau, 0.6), it has one, and no part
    that is said to rest moves by a chance above `doubt`.

    A shape is taken or refused as a whole: a label with a joint too few teaches that the part does not move.
    """
    joints = []
    for index, body in prediction.mobility.movable():
        best = prediction.estimates[index][0]
        joints.append(JudgedJoint(body.name, _name(best.type), float(best.score)))
    refusal = ""
    if not joints:
        refusal = "no moving part was found"
    elif (worst := min(joints, key=lambda joint: joint.score)).score <= threshold:
        refusal = f"a joint scores no more than {threshold:g}: {worst.type}"
    elif prediction.doubt > doubt:
        refusal = f"a part that is said to rest moves by a chance above {doubt:g}"
    return Judgement(prediction.shape_id, layout, prediction.category, tuple(joints), refusal, float(prediction.doubt))


def _name(motion: MotionType | CoarseType) -> str:
    return motion.name


@dataclass(frozen=True)
class Tally:
    """Shapes and joints of one group. `at_least[i]` counts joints that score more than `STEPS[i]`."""

    shapes: int
    accepted: int
    joints: int
    accepted_joints: int
    at_least: tuple[int, ...]


def tally(judgements: Iterable[Judgement]) -> Tally:
    """Count a group."""
    group = list(judgements)
    accepted = [judgement for judgement in group if judgement.is_accepted]
    scores = [joint.score for judgement in group for joint in judgement.joints]
    return Tally(
        len(group),
        len(accepted),
        len(scores),
        sum(len(judgement.joints) for judgement in accepted),
        tuple(sum(score > step for score in scores) for step in STEPS),
    )


def tally_types(judgements: Iterable[Judgement]) -> Mapping[str, Tally]:
    """Count joints by motion type; shapes are those with a joint of the type."""
    group = list(judgements)
    names = sorted({joint.type for judgement in group for joint in judgement.joints})
    return {name: tally(_only(judgement, name) for judgement in group if _only(judgement, name).joints) for name in names}


def _only(judgement: Judgement, motion: str) -> Judgement:
    joints = tuple(joint for joint in judgement.joints if joint.type == motion)
    return Judgement(judgement.shape_id, judgement.layout, judgement.category, joints, judgement.refusal)
