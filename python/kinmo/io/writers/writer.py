"""The common interface of all writers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from kinmo.core.mobility import Mobility
from kinmo.core.shape import Shape
from kinmo.core.shape_estimate import PredictionProvenance, ShapeEstimate


@dataclass(frozen=True)
class ExportOptions:
    """Settings of an export. Each writer uses those that its format needs.

    Attributes:
        name: file name of the model, without ending.
        metres_per_unit: length of one unit of the shape's file, in metres.
        meta: facts to add to the metadata of the format.
        provenance: the models and settings that made the prediction.
    """

    name: str = "model"
    metres_per_unit: float = 1.0
    meta: Mapping[str, Any] = field(default_factory=dict)
    provenance: PredictionProvenance = field(default_factory=PredictionProvenance)


DEFAULT_OPTIONS = ExportOptions()


class Writer(Protocol):
    """A function that writes a shape with its joints in one format.

    Args:
        shape: the shape.
        result: a prediction, or a bare mobility such as an annotation. Both are in the frame and the length unit of the shape.
        folder: the folder to write into. It is created if it does not exist.
        options: the settings.

    Returns:
        The path of the main file, or `folder` if the format has none.
    """

    def __call__(
        self, shape: Shape, result: ShapeEstimate | Mobility, folder: Path, options: ExportOptions = DEFAULT_OPTIONS, /
    ) -> Path: ...


def mobility_of(result: ShapeEstimate | Mobility) -> Mobility:
    """The mobility of a prediction, or the bare mobility itself."""
    return result.mobility if isinstance(result, ShapeEstimate) else result
