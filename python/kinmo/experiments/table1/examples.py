"""Answers to true joints that evaluation keeps, so that the report can show hits and failures."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from kinmo.core.errors import InputError
from kinmo.core.joint import Joint, JointKind
from kinmo.core.prediction import JointEstimate
from kinmo.evaluation.joint_records import JointRecord
from kinmo.evaluation.summary import axis_degrees
from kinmo.io.atomic_files import write_text_atomically


@dataclass(frozen=True)
class Answer:
    """What one row of the table says of a joint. Axis in the normalised frame; None where it says that nothing moves."""

    type: str
    direction: tuple[float, ...] | None
    pivot: tuple[float, ...] | None
    kind: str | None
    axis_degrees: float | None
    line: float | None
    is_ok: bool

    @property
    def joint(self) -> Joint | None:
        if self.kind is None or self.direction is None or self.pivot is None:
            return None
        return Joint(JointKind(self.kind), np.array(self.direction), np.array(self.pivot))

    @property
    def text(self) -> str:
        """For people."""
        if self.axis_degrees is None:
            return f"{self.type}: missed"
        line = "" if self.line is None else f", {self.line:.3f} diagonals"
        return f"{self.type}, {self.axis_degrees:.1f}°{line}"


@dataclass(frozen=True)
class Example:
    """One true joint (body `body` of the annotation of a shape) and the answers of the rows of Table 1, *parts given*."""

    shape_id: str
    layout: str
    category: str
    body: int
    name: str
    true_type: str
    answers: Mapping[str, Answer]


def answer_of(record: JointRecord, estimate: JointEstimate | None) -> Answer:
    """The answer `estimate` with the errors that `record` says it has."""
    joint = None if estimate is None or record.is_missed else estimate.joint
    return Answer(
        record.predicted_type.name if record.predicted_type is not None else "none",
        None if joint is None else tuple(joint.direction.tolist()),
        None if joint is None else tuple(joint.pivot.tolist()),
        None if joint is None else joint.kind.value,
        axis_degrees(record),
        record.line_at_part,
        record.is_ok,
    )


def write_examples(path: Path, examples: Iterable[Example]) -> None:
    """Write one JSON line an example."""
    write_text_atomically(path, "".join(json.dumps(asdict(example), ensure_ascii=False) + "\n" for example in examples))


def read_examples(path: Path) -> list[Example]:
    """The examples of a file; none if there is no file. Raises InputError if it is not what `write_examples` writes."""
    if not path.exists():
        return []
    try:
        return [example_from_data(json.loads(line)) for line in path.read_text(encoding="utf-8").splitlines()]
    except (ValueError, TypeError, KeyError) as error:
        raise InputError(path, f"expected examples of kinmo eval ({error})") from error


def example_from_data(data: Mapping[str, Any]) -> Example:
    """The example that `asdict` took apart. Raises KeyError or TypeError for anything else."""
    return Example(**{**data, "answers": {name: Answer(**answer) for name, answer in data["answers"].items()}})


def chosen(examples: Iterable[Example], count: int) -> list[Example]:
    """At most `count` examples, of as many categories as there are: the first of each category, then the second, and so on."""
    turn: dict[str, int] = {}
    ranked = []
    for example in examples:
        turn[example.category] = turn.get(example.category, 0) + 1
        ranked.append((turn[example.category], example.category, example))
    return [example for _, _, example in sorted(ranked, key=lambda entry: entry[:2])[:count]]
