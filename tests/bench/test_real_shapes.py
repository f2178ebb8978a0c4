"""Folds of real and of procedural shapes."""

from __future__ import annotations

from kinmo.dataset.splits import Split, split_of
from kinmo.dataset.store import IndexEntry
from real_shapes import folds_of, split_training

CATEGORIES = ("Safe", "Table", "Laptop", "Door", "Mechanism")


def entry(name: str, category: str = "Safe", copy_of: str | None = None) -> IndexEntry:
    return IndexEntry(name, "partnet_mobility", category, f"{name}.file", name, name, None, copy_of or name, 2, 2, 1, True)


ENTRIES = [entry(str(number), CATEGORIES[number % len(CATEGORIES)]) for number in range(60)]


def test_every_shape_is_tested_once():
    tested = [each.id for _, some in folds_of(ENTRIES, 5) for each in some]
    assert sorted(tested) == sorted(each.id for each in ENTRIES)


def test_a_fold_trains_on_all_shapes_that_it_does_not_test():
    for fold, tested in folds_of(ENTRIES, 5):
        kept = fold(ENTRIES)
        assert {each.file for each in kept} == {each.file for each in ENTRIES} - {each.file for each in tested}
        assert not any(split_of(each.id) is Split.TEST for each in kept)


def test_copies_of_a_tested_shape_are_not_trained_on():
    fold, (tested, *_) = next(folds_of(ENTRIES, 5))
    copies = [entry(f"copy {number}", copy_of=tested.id) for number in range(10)]
    assert not all(map(fold.tests, copies))
    assert not {each.file for each in copies} & {each.file for each in fold([*ENTRIES, *copies])}


def test_whole_categories_are_left_out_and_shapes_without_one_always_train():
    folds = list(folds_of(ENTRIES, 3, "category"))
    assert {each.category for _, some in folds for each in some} == set(CATEGORIES) - {"Mechanism"}
    for fold, tested in folds:
        kept = {each.category for each in fold(ENTRIES)}
        assert "Mechanism" in kept and not kept & {each.category for each in tested}


def test_folds_that_test_nothing_are_left_out():
    assert [tested for _, tested in folds_of(ENTRIES[:1], 5)] == [ENTRIES[:1]]


def test_validation_shapes_are_those_of_the_pipeline():
    training, validation = split_training(ENTRIES)
    assert len(training) + len(validation) == len(ENTRIES)
    assert {split_of(each.id) for each in validation} == {Split.VALIDATION}
