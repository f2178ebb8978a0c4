"""The common interface of all writers, and what they share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from kinmo.core.mobility import Mobility
from kinmo.core.shape import Mesh, Shape
from kinmo.core.shape_estimate import PredictionProvenance, ShapeEstimate


@dataclass(frozen=True)
class ExportOptions:
    """Settings of an export. Each writer uses those that its format needs.

    Attributes:
        name: file name of the model, without ending.
        metres_per_unit: length of one unit of the shape's file, in metres.
        meta: facts to add to the metadata of the format.
        provenance: the models and settings that made the prediction.
        formats: all formats of the export, keys of `kinmo.io.writers.WRITERS`.
    """

    name: str = "model"
    metres_per_unit: float = 1.0
    meta: Mapping[str, Any] = field(default_factory=dict)
    provenance: PredictionProvenance = field(default_factory=PredictionProvenance)
    formats: tuple[str, ...] = ()


DEFAULT_OPTIONS = ExportOptions()


class Writer(Protocol):
    """A function that writes a shape with its joints in one format into a folder, which is created if necessary.

    The joints are a prediction, or a bare mobility such as an annotation. Both are in the frame and the length unit of the
    shape. The function returns the path of the main file, or `folder` if the format has none.
    """

    def __call__(
        self, shape: Shape, result: ShapeEstimate | Mobility, folder: Path, options: ExportOptions = DEFAULT_OPTIONS, /
    ) -> Path: ...


def mobility_of(result: ShapeEstimate | Mobility) -> Mobility:
    """The mobility of a prediction, or the bare mobility itself."""
    return result.mobility if isinstance(result, ShapeEstimate) else result


def write_obj(path: Path, mesh: Mesh) -> None:
    """Write a mesh to an OBJ file, with all digits of its vertices and with its faces as they are."""
    vertices = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in mesh.vertices.tolist())
    faces = "".join(f"f {a} {b} {c}\n" for a, b, c in (mesh.faces.astype(int) + 1).tolist())
    path.write_text(vertices + faces, encoding="ascii")
