"""Real PartNet-Mobility objects are prepared without loss."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

from kinmo.core.motion_types import MotionType
from kinmo.dataset.store import read_prepared, to_bytes
from kinmo.features.prepared_shape import Boxes
from kinmo.features.shape_preparation import prepare_shape
from kinmo.io.readers import read_partnet_mobility


def folder_of(real_objects, name):
    return next((folder for folder in real_objects if folder.name == name), None) or pytest.skip(f"{name} is not there")


@pytest.mark.real
@pytest.mark.parametrize("name", ["40147", "41083"])
def test_doors_turn_about_vertical_sides_and_drawers_slide_horizontally(real_objects, name):
    shape = prepare_shape(read_partnet_mobility(folder_of(real_objects, name)), points=64)
    kinds = {body.name: shape.body_types[index] for index, body in shape.mobility.movable()}
    assert kinds
    for body, kind in kinds.items():
        assert kind is (MotionType.P_H if "drawer" in body else MotionType.R_V_S), body


@pytest.mark.real
def test_real_objects_are_prepared_to_finite_arrays_that_come_back(real_objects, tmp_path):
    for folder in real_objects[::24]:
        prepared = prepare_shape(read_partnet_mobility(folder), points=64)
        arrays = [prepared.leaf_points, prepared.leaf_normals, prepared.leaf_areas, prepared.edge_distances]
        for boxes in (prepared.minimum_boxes, prepared.symmetric_boxes, prepared.aligned_boxes, prepared.body_boxes):
            arrays += [getattr(boxes, field.name) for field in fields(Boxes)]
            assert np.all(boxes.half_extents >= 0) and np.all(boxes.half_extents.max(axis=1) > 0)
            np.testing.assert_allclose(
                boxes.axes @ np.moveaxis(boxes.axes, 1, 2), np.tile(np.eye(3), (len(boxes), 1, 1)), atol=1e-9
            )
        assert all(np.all(np.isfinite(array)) for array in arrays)
        np.testing.assert_allclose(np.linalg.norm(prepared.leaf_normals, axis=-1), 1.0, atol=1e-5)
        assert np.all(prepared.edge_distances >= 0) and np.all(np.abs(prepared.leaf_points) <= 0.5 + 1e-6)
        (tmp_path / "shape").write_bytes(to_bytes(prepared))
        np.testing.assert_array_equal(read_prepared(tmp_path / "shape").leaf_points, prepared.leaf_points)
