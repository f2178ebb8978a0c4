"""Picture of an evaluated joint: the shape, its moving part, and the true and predicted axes."""

from __future__ import annotations

from collections.abc import Mapping

from kinmo.core.errors import InputError
from kinmo.core.normalisation import Normalisation
from kinmo.dataset.store import PreparedStore
from kinmo.features.prepared_shape import check_unchanged
from kinmo.io.discover import ShapeSource
from kinmo.pipeline.evaluation.example_predictions import Example
from kinmo.view.shape_picture import Axis, object_picture


def draw_example(store: PreparedStore, example: Example, roles: Mapping[str, str]) -> str:
    """Draw an example.

    Args:
        store: The prepared shapes.
        example: The true joint and its predictions.
        roles: Name of the table's row for each style of axis.

    Returns:
        An SVG.

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
    bodies = [prepared.mobility.bodies[index] for index in prepared.mobility.descendants(example.body)]
    place = {leaf: position for position, leaf in enumerate(shape.leaves)}
    moving = frozenset(place[leaf] for body in bodies for leaf in body.leaves)
    truth = prepared.mobility.bodies[example.body].joint
    axes = [] if truth is None else [Axis(truth, "truth")]
    for role, row in roles.items():
        joint = example.predictions[row].joint
        if joint is not None:
            axes.append(Axis(joint, role))
    label = f"{example.category} {example.shape_id}: {example.name}"
    return object_picture(tuple(map(frame.mesh, shape.meshes())), moving, tuple(axes), prepared.up, label)
