"""Forms of labelled shapes for the kinmo method, and the proposals that are added to them."""

from __future__ import annotations

import numpy as np
import pytest
from small_shapes import cabinet_shape
from trained_workspace import Recorder, Trained, tiny_config

from kinmo.config import load_config
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.store import IndexEntry, read_prepared
from kinmo.dataset.workspace import Workspace
from kinmo.features.candidate_features import CandidateFeatures
from kinmo.learning.model_folder import WEIGHTS, ModelFolder
from kinmo.methods.kinmo.grouping.part_grouper import PartGrouper
from kinmo.methods.kinmo.limits.travel_examples import read_examples
from kinmo.methods.kinmo.ranking.training_views import training_groups
from kinmo.pipeline.training_forms import FORMS, TrainingForms, training_form


@pytest.fixture
def entries(trained: Trained) -> list[IndexEntry]:
    return list(open_dataset(trained.workspace).labelled[Split.TRAIN][:2])


def test_forms_are_the_same_at_every_call() -> None:
    shape = cabinet_shape(1)[0]
    for form in FORMS:
        one, other = (training_form(shape, form) for _ in range(2))
        assert [part.name for part in one.parts] == [part.name for part in other.parts]
        for first, second in zip(one.meshes(), other.meshes(), strict=True):
            np.testing.assert_array_equal(first.vertices, second.vertices)


def test_forms_keep_the_joints() -> None:
    shape = cabinet_shape(1)[0]
    assert shape.mobility is not None
    for form in FORMS:
        mobility = training_form(shape, form).mobility
        assert mobility is not None
        assert len(list(mobility.movable())) == len(list(shape.mobility.movable()))
    assert not any(part.name for part in training_form(shape, "pieces").parts[1:])


def test_unchanged_forms_are_not_prepared_again(trained: Trained, entries: list[IndexEntry], tmp_path) -> None:
    forms = TrainingForms(Workspace(tmp_path, prepared=trained.copy(tmp_path / "copy").prepared), 1)
    files = forms.files(entries)
    assert files and forms.folder.parent == tmp_path / "copy" / "workspace"
    recorder = Recorder()
    forms.prepare(entries, recorder)
    assert not recorder.steps
    files[0].unlink()
    forms.prepare(entries, recorder)
    assert recorder.steps == ["preparing forms"] and forms.files(entries) == files


def test_joints_of_forms_are_examples_of_limits(trained: Trained, entries: list[IndexEntry]) -> None:
    found = [read_examples(path) for path in TrainingForms(trained.workspace, 1).files_of_limits(entries)]
    assert found and all(len(examples) for examples in found)


def test_forms_with_proposals_have_the_candidate_joints_that_training_needs(
    trained: Trained, entries: list[IndexEntry], tmp_path
) -> None:
    grouping = ModelFolder(trained.workspace.models).folder("grouping") / WEIGHTS
    config = load_config(tiny_config(tmp_path)).ranking
    grouper = PartGrouper.load(grouping, "cpu")
    for path in TrainingForms(trained.workspace, 1).files_with_proposals(entries):
        shape = read_prepared(path)
        known = CandidateFeatures.of(shape.candidate_features).group_of
        assert set(training_groups(shape, grouper, config)) <= set(known)
