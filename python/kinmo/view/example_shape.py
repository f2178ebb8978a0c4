"""Shapes of the examples in a report, and their scenes: the predicted joint beside the true one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from kinmo.core.errors import InputError
from kinmo.core.joint import Joint
from kinmo.core.normalisation import Normalisation
from kinmo.core.shape import Shape
from kinmo.dataset.store import PreparedStore
from kinmo.features.prepared_shape import check_unchanged
from kinmo.io.discover import ShapeSource
from kinmo.pipeline.evaluation.example_predictions import Example
from kinmo.view.object_scene import ObjectScene, SceneOption
from kinmo.view.scene_building import scene_of, with_options

TRUTH = "true joint"
"""Name of the annotated joint among the options."""


def example_shape(store: PreparedStore, example: Example) -> Shape:
    """The shape of an example with its annotation, in the normalised frame.

    Raises:
        InputError: The shape is gone, is not annotated any more, or cannot be read from its source.
    """
    entry = next((e for e in store.entries if (e.id, e.layout) == (example.shape_id, example.layout)), None)
    if entry is None:
        raise InputError(store.folder, f"there is no shape {example.shape_id} any more: run kinmo eval again")
    prepared = store.load(entry)
    if prepared.mobility is None or example.body >= len(prepared.mobility.bodies):
        raise InputError(entry.source, "expected an annotated shape: run kinmo eval again")
    shape = ShapeSource.of(entry).read()
    check_unchanged(shape, prepared)
    frame = Normalisation(prepared.center, prepared.diagonal)
    parts = (part if part.mesh is None else replace(part, mesh=frame.mesh(part.mesh)) for part in shape.parts)
    x, y, z = prepared.up.tolist()
    return replace(shape, parts=tuple(parts), mobility=prepared.mobility, up=(x, y, z), metres_per_unit=shape.diagonal)


def example_scene(shape: Shape, example: Example, rows: Mapping[str, str]) -> ObjectScene:
    """The scene of an example. Its body can move by each predicted joint, and by the true one.

    Args:
        shape: The shape, by `example_shape`.
        example: The example.
        rows: Rows of the table to show, and what they are called, the first one at the start.
    """
    assert shape.mobility is not None, "examples are annotated"
    truth = shape.mobility.bodies[example.body].joint
    options = [SceneOption(title, _as_limited(example.predictions[row].joint, truth)) for row, title in rows.items()]
    options.append(SceneOption(TRUTH, truth))
    scene = with_options(scene_of(replace(shape, repairs=(), guesses={})), example.body, options)
    return replace(scene, name=f"{example.category} {example.shape_id}", facts=f"{example.name}: {example.true_type}")


def _as_limited(joint: Joint | None, truth: Joint | None) -> Joint | None:
    """A joint without limits, with those of the true joint if it is of the same kind."""
    if joint is None or truth is None or joint.kind is not truth.kind:
        return joint
    same = truth if float(np.dot(joint.direction, truth.direction)) >= 0.0 else truth.reversed()
    return replace(joint, lower=same.lower, upper=same.upper, rest=same.rest)
