"""The JSON document of a prediction for a scan."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from kinmo.core.joint import JointKind
from kinmo.pipeline.scans.predict_scans import scan_document
from kinmo.scans.object_structure import Structure
from kinmo.scans.poses.scan_estimate import PartPoses, ScanEstimate


def test_a_document_has_axes_as_rows_and_states_with_units() -> None:
    kinds = (JointKind.REVOLUTE, JointKind.PRISMATIC, JointKind.SCREW)
    structure, rng = Structure(kinds, (0, 1, 0)), np.random.default_rng(0)
    rotations = Rotation.random(4, random_state=0).as_matrix()
    poses = PartPoses(rotations, rng.uniform(0.2, 2.0, 4), rng.normal(size=(4, 3)))
    centers, halves, inliers = rng.normal(size=(4, 3)), rng.uniform(0.1, 1.0, (4, 3)), rng.uniform(size=4)
    directions, pivots = Rotation.random(3, random_state=1).as_matrix()[:, 0], rng.normal(size=(3, 3))
    states, turns = np.array([0.3, 0.2, 0.1]), np.array([np.nan, np.nan, 1.5])
    found = ScanEstimate(poses, centers, halves, inliers, directions, pivots, states, turns)
    of_points = np.array([0, 1, 1, 3, -1], np.int16)
    document = scan_document(found, of_points, structure, Path("scan.npz"), {"category": "Crane"})
    assert document["category"] == "Crane" and document["scan"] == str(Path("scan.npz").resolve())
    assert [part["points"] for part in document["parts"]] == [1, 2, 0, 1]
    signs = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), axis=-1).reshape(-1, 3)
    for row, part in enumerate(document["parts"]):
        assert part["inliers"] == inliers[row]
        box, pose = part["box"], {name: np.array(value) for name, value in part["pose"].items()}
        corners = box["center"] + signs * box["half_sizes"] @ np.array(box["axes"])
        npcs = (corners - pose["translation"]) @ pose["rotation"] / pose["scale"]
        middle = (centers[row] - poses.translations[row]) @ rotations[row] / poses.scales[row]
        np.testing.assert_allclose(npcs - middle, signs * halves[row] / poses.scales[row], atol=1e-12)
    joints = [(each["part"], each["parent"], each["state"], each["unit"], each["turn"]) for each in document["joints"]]
    lengths = "lengths of the scan"
    assert joints == [(1, 0, 0.3, "radians", None), (2, 1, 0.2, lengths, None), (3, 0, 0.1, lengths, 1.5)]
    assert [each["pivot"] is None for each in document["joints"]] == [False, True, False]
    np.testing.assert_array_equal([each["direction"] for each in document["joints"]], directions)
    json.dumps(document, allow_nan=False)


def test_direction_and_pivot_of_a_part_that_was_not_found_are_unknown() -> None:
    structure = Structure((JointKind.REVOLUTE, JointKind.REVOLUTE), (0, 0))
    poses = PartPoses(np.tile(np.eye(3), (3, 1, 1)), np.ones(3), np.zeros((3, 3)))
    directions = np.array([[0.0, 1.0, 0.0], [np.nan] * 3])
    places, known = np.ones((3, 3)), np.ones(2)
    found = ScanEstimate(poses, places, places, np.ones(3), directions, np.ones((2, 3)), known, known)
    document = scan_document(found, np.zeros(4, np.int16), structure, Path("scan.npz"), {})
    assert [(joint["direction"], joint["pivot"]) for joint in document["joints"]] == [([0, 1, 0], [1, 1, 1]), (None, None)]
