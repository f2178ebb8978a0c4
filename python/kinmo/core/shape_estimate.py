"""Predictions of a method for a shape: bodies, ranked joint estimates, and their scores."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint
from kinmo.core.mobility import Mobility
from kinmo.core.motion_types import CoarseType, MotionType

OVERRIDE = "override"
"""Source of a joint that was corrected by hand."""


@dataclass(frozen=True, eq=False)
class JointEstimate:
    """One estimate of the joint of a body.

    Attributes:
        joint: the estimated joint. None if the body is estimated not to move.
        type: the motion type, fine or coarse as the model has it.
        score: confidence in [0, 1]. The `paper` method gives the consistency score of the paper (section 3.3), the `kinmo`
            method a probability.
        terms: the terms of the score by name, such as feasibility, direction, position or sweep.
        source: where the axis comes from: "network" for a regressed axis, `OVERRIDE` for a joint given by hand, else the kind
            of candidate axis, such as "box edge".
    """

    joint: Joint | None
    type: MotionType | CoarseType
    score: float
    terms: Mapping[str, float] = field(default_factory=dict)
    source: str = "network"

    def rotated(self, rotation: NDArray[np.float64]) -> JointEstimate:
        """The estimate in a frame that `rotation` [3, 3] rotates the present frame to."""
        return self if self.joint is None else replace(self, joint=self.joint.rotated(rotation))


@dataclass(frozen=True, eq=False)
class ShapeEstimate:
    """The predicted mobility of one shape, in the frame and the length unit of the shape.

    Attributes:
        shape_id: the id of the shape.
        category: the category that was assumed.
        mobility: the predicted bodies and joints.
        estimates: for each body its ranked estimates, the best one first. The first one is the joint of the body, the others
            are the alternatives.
        gnn_estimates: for each body the joint as the motion GNN regressed it, before refinement. Empty for a method
            without a motion GNN.
        method: name of the method, `paper` or `kinmo`.
        missed_motion_probability: the largest probability that a part moves although the prediction leaves it at rest. 0 if the
            method does not estimate it.
        correction: what was corrected by hand. None for the estimate of a method.
    """

    shape_id: str
    category: str
    mobility: Mobility
    estimates: tuple[tuple[JointEstimate, ...], ...]
    gnn_estimates: tuple[JointEstimate, ...]
    method: str
    missed_motion_probability: float = 0.0
    correction: Correction | None = None

    @property
    def predicted(self) -> ShapeEstimate:
        """The estimate of the method, without corrections by hand."""
        return self if self.correction is None else self.correction.predicted

    def rotated(self, rotation: NDArray[np.float64]) -> ShapeEstimate:
        """The prediction in a frame that `rotation` [3, 3] rotates the present frame to."""
        return replace(
            self,
            mobility=self.mobility.rotated(rotation),
            estimates=tuple(tuple(each.rotated(rotation) for each in ranked) for ranked in self.estimates),
            gnn_estimates=tuple(each.rotated(rotation) for each in self.gnn_estimates),
            correction=None if self.correction is None else self.correction.rotated(rotation),
        )


@dataclass(frozen=True, eq=False)
class Correction:
    """Correction of a prediction by hand.

    Attributes:
        predicted: the estimate of the method, before the correction.
        overrides: the content of overrides.toml as plain data, in the frame of the file.
        notes: one line for each consequence that overrides.toml does not name, such as a body without parts that is dropped.
    """

    predicted: ShapeEstimate
    overrides: Mapping[str, Any]
    notes: tuple[str, ...] = ()

    def rotated(self, rotation: NDArray[np.float64]) -> Correction:
        """The correction of the estimate in a frame that `rotation` [3, 3] rotates the present frame to."""
        return replace(self, predicted=self.predicted.rotated(rotation))


@dataclass(frozen=True)
class PredictionProvenance:
    """The models and settings that made a prediction.

    Attributes:
        weights: hash of the models. None for a method without models.
        config: the settings of the method, as plain data.
    """

    weights: str | None = None
    config: Mapping[str, Any] = field(default_factory=dict)
