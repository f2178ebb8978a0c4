"""Splits are fixed by a hash of the id, and copies of labelled shapes never leak."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinmo.dataset.splits import (
    PAPER_TEST_IDS,
    Split,
    fold_of,
    leaks,
    split_of,
    validation_from_training,
)

ids = st.text(min_size=1, max_size=8)
MANY = [str(number) for number in range(20_000)]


@dataclass(frozen=True)
class Shape:
    id: str
    partnet_id: str | None
    geometry_hash: str


shapes = st.builds(Shape, ids, st.none() | st.sampled_from("123"), st.sampled_from("abcdef"))


def test_splits_stay_as_they_are():
    """A change here would mix training and test data of results that are already published."""
    assert "".join(split_of(f"shape-{i}").value[0:2] for i in range(12)) == "tetrtrtetrtrtrvavatrteva"
    assert [fold_of(f"shape-{i}") for i in range(12)] == [2, 0, 3, 2, 0, 1, 4, 4, 2, 1, 2, 1]


def test_shares_are_as_stated():
    counts = Counter(split_of(shape_id) for shape_id in MANY)
    assert counts[Split.TEST] / len(MANY) == pytest.approx(0.2, abs=0.01)
    assert counts[Split.VALIDATION] / len(MANY) == pytest.approx(0.1, abs=0.01)
    folds = Counter(fold_of(shape_id) for shape_id in MANY)
    assert sorted(folds) == [0, 1, 2, 3, 4]
    assert max(folds.values()) - min(folds.values()) < 0.02 * len(MANY)


def test_the_papers_test_shapes_are_test():
    assert {split_of(shape_id) for shape_id in PAPER_TEST_IDS} == {Split.TEST}


@given(ids, st.integers(1, 10))
def test_every_shape_has_one_of_the_folds(shape_id, folds):
    assert 0 <= fold_of(shape_id, folds) < folds


@given(st.lists(shapes, max_size=8), st.lists(shapes, max_size=8), st.sets(ids, max_size=4))
def test_copies_of_labelled_shapes_leak_unless_the_label_is_an_oracle_label(unlabelled, labelled, oracle):
    for shape, leak in zip(unlabelled, leaks(unlabelled, labelled, oracle), strict=True):
        copies = [
            other
            for other in labelled
            if other.geometry_hash == shape.geometry_hash
            or (shape.partnet_id is not None and other.partnet_id == shape.partnet_id)
        ]
        assert leak == any(other.id not in oracle for other in copies)


def test_shapes_without_partnet_id_are_not_copies_of_each_other():
    assert leaks([Shape("a", None, "x")], [Shape("b", None, "y")], set()) == [False]


@given(st.sets(ids, min_size=2, max_size=40))
def test_a_tenth_of_the_training_shapes_and_never_all_can_validate(shapes):
    moved = validation_from_training(shapes)
    assert moved < shapes
    assert len(moved) == max(1, round(0.1 * len(shapes)))
