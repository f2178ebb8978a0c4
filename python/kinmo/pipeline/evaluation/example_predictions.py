"""Predictions for true joints that evaluation keeps, so that the report can show right and wrong ones."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from kinmo.core.errors import expecting
from kinmo.core.joint import Joint, JointKind
from kinmo.core.shape_estimate import JointEstimate
from kinmo.evaluation.joint_records import JointRecord
from kinmo.evaluation.score_summary import axis_degrees
from kinmo.io.atomic_files import write_text_atomically


@dataclass(frozen=True)
class ExamplePrediction:
    """One method's prediction for a true joint, in the normalised frame. Direction, pivot and kind are None without a joint."""

    type: str  # motion type, or "none"
    direction: tuple[float, ...] | None
    pivot: tuple[float, ...] | None
    kind: str | None
    axis_degrees: float | None  # angle to the true axis; None for a missed joint
    line: float | None  # distance from the true axis line at the part, in diagonals; None for sliders and missed joints
    is_ok: bool  # the joint is right (`kinmo.evaluation.metrics`)

    @property
    def joint(self) -> Joint | None:
        """The predicted joint; None for a missed one."""
        if self.kind is None or self.direction is None or self.pivot is None:
            return None
        return Joint(JointKind(self.kind), np.array(self.direction), np.array(self.pivot))

    @property
    def text(self) -> str:
        """The prediction and its errors in words."""
        if self.axis_degrees is None:
            return f"{self.type}: missed"
        line = "" if self.line is None else f", {self.line:.3f} diagonals"
        return f"{self.type}, {self.axis_degrees:.1f}°{line}"


@dataclass(frozen=True)
class Example:
    """The true joint of one `body` of a test shape, with the predictions of several methods (by row of the table)."""

    shape_id: str
    layout: str
    category: str
    body: int
    name: str
    true_type: str
    predictions: Mapping[str, ExamplePrediction]


def example_prediction(record: JointRecord, estimate: JointEstimate | None) -> ExamplePrediction:
    """The prediction `estimate` with the errors of its `record`."""
    kind = "none" if record.predicted_type is None else record.predicted_type.name
    joint = None if estimate is None or record.is_missed else estimate.joint
    axis: tuple[Any, Any, Any] = (None, None, None)
    if joint is not None:
        axis = (tuple(joint.direction.tolist()), tuple(joint.pivot.tolist()), joint.kind.value)
    return ExamplePrediction(kind, *axis, axis_degrees(record), record.line_at_part, record.is_ok)


def write_examples(path: Path, examples: Iterable[Example]) -> None:
    """Write one JSON line per example."""
    write_text_atomically(path, "".join(json.dumps(asdict(example), ensure_ascii=False) + "\n" for example in examples))


def read_examples(path: Path) -> list[Example]:
    """Read the examples of a file; none if there is no file. Raises InputError if `write_examples` did not write it."""
    if not path.exists():
        return []
    with expecting("examples of kinmo eval", path):
        return [example_from_data(json.loads(line)) for line in path.read_text(encoding="utf-8").splitlines()]


def example_from_data(data: Mapping[str, Any]) -> Example:
    """The example that `dataclasses.asdict` took apart. Raises KeyError or TypeError for anything else."""
    predictions = {name: ExamplePrediction(**found) for name, found in data["predictions"].items()}
    return Example(**{**data, "predictions": predictions})


def spread_over_categories(examples: Iterable[Example], count: int) -> list[Example]:
    """Choose at most `count` examples: the first of each category, then the second of each, and so on."""
    turn: dict[str, int] = {}
    ranked = []
    for example in examples:
        turn[example.category] = turn.get(example.category, 0) + 1
        ranked.append((turn[example.category], example.category, example))
    return [example for _, _, example in sorted(ranked, key=lambda entry: entry[:2])[:count]]
