"""Shapes train, test, or are pseudo-labelled, according to their entries in the index."""

from __future__ import annotations

import pytest

from kinmo.dataset.shape_dataset import fingerprint, open_dataset
from kinmo.dataset.splits import Split, split_of
from kinmo.dataset.store import IndexEntry, file_name, write_index
from kinmo.dataset.workspace import Workspace

ANNOTATED = [f"box-{i}" for i in range(60)]
ORACLE = [f"far-{i}" for i in range(60)]


def entry(shape_id, layout="partnet_mobility", category="Box", *, labelled=True, oracle=False, geometry=None):
    geometry = shape_id if geometry is None else geometry
    path = file_name(layout, shape_id)
    return IndexEntry(shape_id, layout, category, path, "/x", f"key {path}", shape_id, geometry, 3, 2, 1, labelled, (), oracle)


def workspace(tmp_path, entries):
    made = Workspace(tmp_path)
    write_index(made.prepared, entries)
    return made


def ids(entries):
    return {entry.id for entry in entries}


@pytest.fixture
def entries():
    return [
        *(entry(name) for name in ANNOTATED),
        *(entry(name, oracle=True) for name in ORACLE),
        *(entry(name, "partnet", labelled=False) for name in ORACLE + ANNOTATED[:20]),
    ]


def test_shapes_with_oracle_labels_test_and_are_pseudo_labelled(tmp_path, entries):
    dataset = open_dataset(workspace(tmp_path, entries))
    tests = {name for name in ORACLE if split_of(name) is Split.TEST}
    assert ids(dataset.labelled[Split.TEST]) == tests | {name for name in ANNOTATED if split_of(name) is Split.TEST}
    for split in (Split.TRAIN, Split.VALIDATION):
        assert ids(dataset.labelled[split]) == {name for name in ANNOTATED if split_of(name) is split}
    assert ids(dataset.oracle) == set(ORACLE) - tests
    assert ids(dataset.unlabelled) == ids(dataset.oracle)
    assert {entry.layout for entry in dataset.unlabelled} == {"partnet"}, "the copies without joints are labelled"
    assert ids(dataset.copies) == tests | set(ANNOTATED[:20])


def test_no_unlabelled_shape_is_a_copy_of_a_labelled_one(tmp_path, entries):
    dataset = open_dataset(workspace(tmp_path, entries))
    used = {entry.geometry_hash for entries in dataset.labelled.values() for entry in entries}
    assert not used & {entry.geometry_hash for entry in dataset.unlabelled}


def test_the_oracle_label_of_a_shape_and_of_its_copies_is_known(tmp_path):
    far, other = (f"{name}-{next(i for i in range(60) if split_of(f'{name}-{i}') is Split.TRAIN)}" for name in ("far", "other"))
    again = entry("again", "dsg_net", labelled=False, geometry=far)
    alone = entry("alone", "partnet", labelled=False)
    dataset = open_dataset(workspace(tmp_path, [entry(far, oracle=True), entry(other), again, alone]))
    assert ids(dataset.unlabelled) == {"again", "alone"}
    assert dataset.oracle_ids == {("again", "dsg_net"): far, (far, "partnet_mobility"): far}


def test_copies_with_labels_in_several_splits_count_only_as_tests(tmp_path):
    names = {split: next(f"twin-{i}" for i in range(99) if split_of(f"twin-{i}") is split) for split in Split}
    made = [entry(name, geometry="same") for name in names.values()]
    dataset = open_dataset(workspace(tmp_path, [*made, *(entry(name) for name in ANNOTATED)]))
    for split, name in names.items():
        assert (name in ids(dataset.labelled[split])) is (split is Split.TEST)
    assert ids(dataset.copies) == {names[Split.TRAIN], names[Split.VALIDATION]}


@pytest.mark.parametrize("split", [Split.TEST, Split.VALIDATION])
@pytest.mark.parametrize("category", ["Box", "Case"])
def test_an_oracle_shape_that_looks_like_a_held_out_shape_is_not_used(tmp_path, split, category):
    held, test = (next(f"{letter}-{i}" for i in range(99) if split_of(f"{letter}-{i}") is own)
                  for letter, own in (("a", Split.TRAIN), ("b", split)))  # fmt: skip
    made = [entry(held, oracle=True, geometry="same"), entry(test, category=category, geometry="same")]
    dataset = open_dataset(workspace(tmp_path, made), "Box")
    assert not dataset.oracle and not dataset.unlabelled
    assert ids(dataset.copies) == {held}


def test_the_fingerprint_changes_with_every_shape(entries):
    assert fingerprint(entries) == fingerprint(list(entries))
    assert len({fingerprint(entries[:count]) for count in range(len(entries))}) == len(entries)
