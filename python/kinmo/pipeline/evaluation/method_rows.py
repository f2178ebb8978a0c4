"""Rows of Table 1 that trained methods predict."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from kinmo.core.errors import InputError
from kinmo.core.shape_estimate import ShapeEstimate
from kinmo.learning.model_folder import ModelFolder
from kinmo.learning.motion_gnn.gnn_network import TypeSet
from kinmo.methods import METHOD_MODELS
from kinmo.methods.kinmo.kinmo_method import KinmoMethod
from kinmo.methods.method import Method
from kinmo.methods.paper.paper_method import PaperMethod

TYPE_SETS: tuple[TypeSet, ...] = ("coarse", "fine")


def gnn_alone(prediction: ShapeEstimate) -> ShapeEstimate:
    """The motion GNN's own prediction, before refinement."""
    mobility, found = prediction.mobility, prediction.gnn_estimates
    bodies = tuple(replace(body, joint=estimate.joint) for body, estimate in zip(mobility.bodies, found, strict=True))
    estimates = tuple((estimate,) for estimate in found)
    return replace(prediction, mobility=replace(mobility, bodies=bodies), estimates=estimates)


@dataclass(frozen=True)
class Row:
    """A row of a table: its name, the method that predicts, and a change of its prediction if there is one."""

    name: str
    method: Method
    change: Callable[[ShapeEstimate], ShapeEstimate] | None = None


def method_rows(models: ModelFolder, methods: Sequence[str], device: str) -> list[Row]:
    """Rows of the methods (`kinmo`, `paper` or both), in the order of printing.

    Raises:
        InputError: There is no such method, or one of its networks is missing or cannot be read.
    """
    for name in methods:
        if name not in METHOD_MODELS:
            raise InputError("methods", f"expected one of {', '.join(METHOD_MODELS)}, got {name}")
    rows: list[Row] = []
    if "kinmo" in methods:
        rows.append(Row("kinmo", KinmoMethod(models, device)))
    if "paper" in methods:
        refinement = models.config().refinement
        for types in TYPE_SETS:
            paper = PaperMethod(models, refinement, types, device)
            rows += [Row(f"GNN_{types}", paper, gnn_alone), Row(f"OBB_{types}", paper)]
    for row in rows:
        row.method.check()
    return rows
