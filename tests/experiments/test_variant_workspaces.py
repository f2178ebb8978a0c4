"""Workspaces with fewer labels, with generated shapes, or with the scans of a noisy sensor."""

from __future__ import annotations

import pickle
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.splits import Split, split_of
from kinmo.dataset.store import IndexEntry, file_name, write_index
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.variant_workspaces import ShapeSelection, Variant, within_share
from kinmo.io.readers import DSG_NET

ANNOTATED = [f"box-{i}" for i in range(60)]
ORACLE = [f"far-{i}" for i in range(60)]


def entry(shape_id, layout="partnet_mobility", category="Box", *, labelled=True, oracle=False):
    path = file_name(layout, shape_id)
    return IndexEntry(shape_id, layout, category, path, "/x", f"key {path}", shape_id, shape_id, 3, 2, 1, labelled, (), oracle)


ENTRIES = [
    *map(entry, ANNOTATED),
    *(entry(name, oracle=True) for name in ORACLE),
    *(entry(name, "partnet", labelled=False) for name in ORACLE + ANNOTATED[:20]),
]


def dataset_of(folder, variant, entries=ENTRIES, category=None):
    root = Workspace(folder)
    write_index(root.prepared, entries)
    return open_dataset(variant.workspace(root), category)


def ids(entries):
    return {entry.id for entry in entries}


@pytest.mark.parametrize("labels", [0.8, 0.5, 0.3])
def test_with_a_share_of_the_labels_the_others_become_oracle_labels(tmp_path, labels):
    whole, part = (dataset_of(tmp_path, variant) for variant in (Variant(), Variant(labels)))
    training = whole.labelled[Split.TRAIN]
    assert len(part.labelled[Split.TRAIN]) == round(labels * len(training))
    assert part.labelled[Split.TEST] == whole.labelled[Split.TEST]
    assert part.labelled[Split.VALIDATION] == whole.labelled[Split.VALIDATION]
    hidden = ids(training) - ids(part.labelled[Split.TRAIN])
    assert ids(part.oracle) == ids(whole.oracle) | hidden
    assert ids(part.unlabelled) == ids(part.oracle)
    for dataset in (whole, part):
        used = {entry.geometry_hash for entries in dataset.labelled.values() for entry in entries}
        assert not used & {entry.geometry_hash for entry in dataset.unlabelled}


def test_smaller_shares_are_parts_of_larger_ones(tmp_path):
    found = [ids(dataset_of(tmp_path, Variant(share)).labelled[Split.TRAIN]) for share in (0.1, 0.3, 0.5, 1.0)]
    assert all(less < more for less, more in pairwise(found))


def test_every_category_keeps_a_label(tmp_path):
    name = next(f"one-{i}" for i in range(99) if split_of(f"one-{i}") is Split.TRAIN)
    entries = [entry(name, category="Rare"), *map(entry, ANNOTATED)]
    assert ids(dataset_of(tmp_path, Variant(0.01), entries, "rare").labelled[Split.TRAIN]) == {name}


@given(st.sets(st.tuples(st.text(min_size=1, max_size=8), st.sampled_from(["Door", "Table"]))), st.floats(0.0, 1.0))
def test_a_share_of_every_category_is_kept(shapes, share):
    entries = [entry(name, category=category) for name, category in shapes]
    kept, more = within_share(entries, share), within_share(entries, min(1.0, 1.5 * share))
    assert within_share(entries, 1.0) == set(entries)
    assert kept <= more
    for category in {entry.category for entry in entries}:
        count = sum(entry.category == category for entry in entries)
        assert sum(entry.category == category for entry in kept) == max(1, round(share * count))


def test_generated_shapes_are_the_only_unlabelled_ones(tmp_path):
    train = [name for name in ORACLE if split_of(name) is Split.TRAIN]
    generated = [entry(name, DSG_NET, labelled=False) for name in ("new", train[0])]
    dataset = dataset_of(tmp_path, Variant(generated=True), [*ENTRIES, *generated])
    assert ids(dataset.unlabelled) == {"new", train[0]}
    assert {entry.layout for entry in dataset.unlabelled} == {DSG_NET}
    assert ids(dataset.oracle) == {train[0]}, "oracle labels count only for copies of generated shapes"
    whole = dataset_of(tmp_path, Variant(), [*ENTRIES, *generated])
    assert dataset.labelled == whole.labelled
    assert set(dataset.unlabelled) <= set(whole.unlabelled), "the original workspace labels them"


def test_a_derived_workspace_follows_the_original_one_and_needs_no_files(tmp_path):
    dataset_of(tmp_path, Variant(0.5))
    dataset = dataset_of(tmp_path, Variant(0.5), ENTRIES[:30])
    assert len(dataset.labelled[Split.TEST]) == sum(split_of(name) is Split.TEST for name in ANNOTATED[:30])
    assert [path.name for path in tmp_path.iterdir()] == ["prepared"]


def test_derived_workspaces_lie_in_the_original_one_and_share_what_they_do_not_change(tmp_path):
    root = Workspace(tmp_path)
    assert Variant().workspace(root) == root == Variant(is_noisy=True).labelling(root)
    for variant, name in (
        (Variant(0.3), "labels-30"),
        (Variant(generated=True), "generated"),
        (Variant(is_noisy=True), "noisy-sensor"),
        (Variant(0.5, is_noisy=True), "labels-50-noisy-sensor"),
    ):
        part, labelling = variant.workspace(root), variant.labelling(root)
        assert part.path == tmp_path / "experiments" / name
        assert (part.prepared, part.journal) == (root.prepared, root.journal)
        assert all(part.path in folder.parents for folder in (part.models, part.scans, part.evaluation))
        assert part.pseudo_labels == labelling.pseudo_labels
        assert labelling == Variant(variant.labels).workspace(root)
        assert (part == labelling) is (variant == Variant(variant.labels))
        assert part == variant.workspace(root) == pickle.loads(pickle.dumps(part))
    assert Variant(0.3).workspace(root) != Variant(0.5).workspace(root)
    assert Variant(0.3).workspace(root).select == ShapeSelection(0.3, False)
    assert Variant(is_noisy=True).workspace(root).select is None
