"""Rows of Table 1 that need no trained method."""

from __future__ import annotations

import numpy as np
import pytest
from trained_workspace import Recorder, Trained

from kinmo.core.joint import Joint, JointKind
from kinmo.core.motion_types import MotionType
from kinmo.core.shape_estimate import JointEstimate
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.splits import Split, split_of
from kinmo.dataset.store import IndexEntry, write_index
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.table1 import baselines
from kinmo.experiments.table1.baselines import PaperBaselines, estimate_from_data, estimate_to_data


def test_without_a_joint_to_learn_from_there_are_no_boosted_trees(tmp_path):
    workspace, observer = Workspace(tmp_path), Recorder()
    name = next(f"box-{i}" for i in range(60) if split_of(f"box-{i}") is Split.TEST)
    write_index(workspace.prepared, [IndexEntry(name, "partnet_mobility", "Box", name, "/x", name, name, name, 3, 2, 1, True)])
    assert PaperBaselines().prepare(workspace, observer) == {}
    assert observer.notes == ["no row of boosted trees: no labelled training shape has a joint"]


def test_boosted_trees_are_trained_once_and_predict_all_test_shapes(trained: Trained, tmp_path, monkeypatch):
    workspace, fitted = trained.copy(tmp_path), []
    known = PaperBaselines().prepare(workspace, Recorder())
    assert set(known) == {entry.file for entry in open_dataset(workspace).labelled[Split.TEST] if entry.joint_count}
    fit = baselines.fit_trees
    monkeypatch.setattr(baselines, "fit_trees", lambda *shapes, **seed: fitted.append(seed) or fit(*shapes, **seed))
    assert PaperBaselines().prepare(workspace, Recorder()) == known
    assert not fitted
    PaperBaselines(seed=1 << 40).prepare(workspace, Recorder())
    assert fitted == [{"seed": 0}], "scikit-learn accepts 32 bits"


@pytest.mark.parametrize("joint", [None, Joint(JointKind.REVOLUTE, np.array([0.0, 1.0, 0.0]), np.array([0.1, 0.2, 0.3]))])
def test_an_estimate_comes_back_from_plain_data(joint):
    estimate = JointEstimate(joint, MotionType.FIXED if joint is None else MotionType.R_V_S, 0.5, source="trees")
    found = estimate_from_data(estimate_to_data(estimate))
    assert (found.type, found.score, found.source) == (estimate.type, 0.5, "trees")
    if joint is None:
        assert found.joint is None
    else:
        assert found.joint.kind is joint.kind
        np.testing.assert_array_equal([found.joint.direction, found.joint.pivot], [joint.direction, joint.pivot])
