"""Which shapes train, test and are labelled, by what the index says of them."""

from __future__ import annotations

from itertools import pairwise

import pytest
from whole_road import Listener

from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.splits import Split, split_of
from kinmo.dataset.store import INDEX, IndexEntry, file_name, index_text
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.table1.trees_answers import trees_answers
from kinmo.learning.model_folder import ModelFolder

ANNOTATED = [f"box-{i}" for i in range(60)]
HELD_BACK = [f"far-{i}" for i in range(60)]


def entry(shape_id, layout="partnet_mobility", category="Box", *, labelled=True, held_back=False, geometry=None):
    geometry = shape_id if geometry is None else geometry
    return IndexEntry(
        shape_id, layout, category, file_name(layout, shape_id), "/x", shape_id, geometry, 3, 2, 1, labelled, (), held_back
    )


def workspace(tmp_path, entries, labels=1.0):
    (tmp_path / "prepared").mkdir(exist_ok=True)
    (tmp_path / "prepared" / INDEX).write_text(index_text(entries), encoding="utf-8")
    return Workspace(tmp_path, labels)


def ids(entries):
    return {entry.id for entry in entries}


@pytest.fixture
def entries():
    return [
        *(entry(name) for name in ANNOTATED),
        *(entry(name, held_back=True) for name in HELD_BACK),
        *(entry(name, "partnet", labelled=False) for name in HELD_BACK + ANNOTATED[:20]),
    ]


def test_what_is_held_back_tests_and_is_labelled_without_its_labels(tmp_path, entries):
    dataset = open_dataset(workspace(tmp_path, entries))
    tests = {name for name in HELD_BACK if split_of(name) is Split.TEST}
    assert ids(dataset.labelled[Split.TEST]) == tests | {name for name in ANNOTATED if split_of(name) is Split.TEST}
    for split in (Split.TRAIN, Split.VALIDATION):
        assert ids(dataset.labelled[split]) == {name for name in ANNOTATED if split_of(name) is split}
    assert ids(dataset.hidden) == set(HELD_BACK) - tests
    assert ids(dataset.unlabelled) == ids(dataset.hidden)
    assert {entry.layout for entry in dataset.unlabelled} == {"partnet"}, "the copies without joints are labelled"
    assert ids(dataset.copies) == tests | set(ANNOTATED[:20])


def test_of_what_is_hidden_or_a_copy_of_it_the_truth_is_known(tmp_path):
    far, other = (f"{name}-{next(i for i in range(60) if split_of(f'{name}-{i}') is Split.TRAIN)}" for name in ("far", "other"))
    again = entry("again", "dsg_net", labelled=False, geometry=far)
    alone = entry("alone", "partnet", labelled=False)
    dataset = open_dataset(workspace(tmp_path, [entry(far, held_back=True), entry(other), again, alone]))
    assert ids(dataset.unlabelled) == {"again", "alone"}
    assert dataset.truths == {("again", "dsg_net"): far, (far, "partnet_mobility"): far}


@pytest.mark.parametrize("labels", [0.8, 0.5, 0.3])
def test_a_share_of_labels_leaves_as_many_to_train_on_and_the_rest_to_label(tmp_path, entries, labels):
    whole, part = (open_dataset(workspace(tmp_path, entries, share)) for share in (1.0, labels))
    training = whole.labelled[Split.TRAIN]
    assert len(part.labelled[Split.TRAIN]) == round(labels * len(training))
    assert part.labelled[Split.TEST] == whole.labelled[Split.TEST]
    assert part.labelled[Split.VALIDATION] == whole.labelled[Split.VALIDATION]
    hidden = ids(training) - ids(part.labelled[Split.TRAIN])
    assert ids(part.hidden) == ids(whole.hidden) | hidden
    assert ids(part.unlabelled) == ids(part.hidden)
    for dataset in (whole, part):
        used = {entry.geometry_hash for entries in dataset.labelled.values() for entry in entries}
        assert not used & {entry.geometry_hash for entry in dataset.unlabelled}


def test_smaller_shares_are_parts_of_larger_ones(tmp_path, entries):
    found = [ids(open_dataset(workspace(tmp_path, entries, share)).labelled[Split.TRAIN]) for share in (0.1, 0.3, 0.5, 1.0)]
    assert all(less < more for less, more in pairwise(found))


def test_every_category_keeps_a_label(tmp_path):
    name = next(f"one-{i}" for i in range(99) if split_of(f"one-{i}") is Split.TRAIN)
    made = workspace(tmp_path, [entry(name, category="Rare"), *(entry(other) for other in ANNOTATED)], 0.01)
    assert ids(open_dataset(made, "rare").labelled[Split.TRAIN]) == {name}


def test_of_copies_with_labels_in_several_splits_only_those_for_tests_count(tmp_path):
    names = {split: next(f"twin-{i}" for i in range(99) if split_of(f"twin-{i}") is split) for split in Split}
    made = [entry(name, geometry="same") for name in names.values()]
    dataset = open_dataset(workspace(tmp_path, [*made, *(entry(name) for name in ANNOTATED)]))
    for split, name in names.items():
        assert (name in ids(dataset.labelled[split])) is (split is Split.TEST)
    assert ids(dataset.copies) == {names[Split.TRAIN], names[Split.VALIDATION]}


def test_without_a_joint_to_learn_from_there_are_no_boosted_trees(tmp_path):
    told, test = Listener(), next(name for name in ANNOTATED if split_of(name) is Split.TEST)
    assert trees_answers(workspace(tmp_path, [entry(test)]), 0, told) is None
    assert told.notes == ["no row of boosted trees: there is no labelled shape with a joint to train them on"]


def test_a_hidden_shape_that_looks_as_a_test_shape_gets_no_label(tmp_path):
    held, test = (next(f"{letter}-{i}" for i in range(99) if split_of(f"{letter}-{i}") is split)
                  for letter, split in (("a", Split.TRAIN), ("b", Split.TEST)))  # fmt: skip
    made = workspace(tmp_path, [entry(held, held_back=True, geometry="same"), entry(test, geometry="same")])
    dataset = open_dataset(made)
    assert ids(dataset.hidden) == {held}
    assert not dataset.unlabelled


def test_workspaces_with_fewer_labels_lie_in_the_whole_one(tmp_path):
    whole, part = Workspace(tmp_path), Workspace(tmp_path, 0.3)
    assert (part.prepared, part.scans) == (whole.prepared, whole.scans)
    assert part.path == tmp_path / "labels-30"
    for own in ("models", "pseudo", "own_scans", "evaluation"):
        assert tmp_path / "labels-30" in getattr(part, own).parents


def test_workspaces_of_another_method_share_all_but_what_comes_of_pseudo_labels(tmp_path):
    whole, part = Workspace(tmp_path, 0.3), Workspace(tmp_path, 0.3, method="paper")
    assert (part.prepared, part.scans) == (whole.prepared, whole.scans)
    assert part.motion == whole == whole.motion != part
    assert (
        ModelFolder(part.motion.models).folder("axis")
        == ModelFolder(whole.motion.models).folder("axis")
        == whole.models / "axis"
    )
    for own in ("models", "pseudo", "own_scans", "evaluation"):
        assert whole.path / "by-paper" in getattr(part, own).parents
