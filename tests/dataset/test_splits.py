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
    is_validation_in_fold,
    kept_to_choose_by,
    leaks,
    split_of,
    within_share,
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


@given(ids, st.integers(2, 10))
def test_a_shape_that_a_fold_tests_is_not_validated_on_in_it(shape_id, folds):
    fold = fold_of(shape_id, folds)
    assert 0 <= fold < folds
    assert not is_validation_in_fold(shape_id, fold, folds)


@given(st.lists(shapes, max_size=8), st.lists(shapes, max_size=8), st.sets(ids, max_size=4))
def test_no_pseudo_label_is_a_copy_of_a_shape_whose_label_is_used_or_held_out(unlabelled, labelled, hidden):
    for shape, leak in zip(unlabelled, leaks(unlabelled, labelled, hidden), strict=True):
        copies = [
            other
            for other in labelled
            if other.geometry_hash == shape.geometry_hash
            or (shape.partnet_id is not None and other.partnet_id == shape.partnet_id)
        ]
        assert leak == any(other.id not in hidden for other in copies)


def test_shapes_without_partnet_id_are_not_copies_of_each_other():
    assert leaks([Shape("a", None, "x")], [Shape("b", None, "y")], set()) == [False]


@given(st.lists(st.tuples(ids, st.sampled_from("AB")), unique=True, max_size=40), st.floats(0.01, 1.0))
def test_of_every_category_a_share_is_kept_and_it_is_part_of_any_larger_one(shapes, share):
    kept, more = within_share(shapes, share), within_share(shapes, min(1.0, 1.5 * share))
    assert all(within_share(shapes, 1.0))
    assert all(larger for smaller, larger in zip(kept, more, strict=True) if smaller)
    for category in {category for _, category in shapes}:
        own = [keep for keep, (_, of) in zip(kept, shapes, strict=True) if of == category]
        assert sum(own) == max(1, round(share * len(own)))


@given(st.sets(ids, min_size=2, max_size=40))
def test_a_tenth_is_kept_to_choose_by_and_never_all(shapes):
    kept = kept_to_choose_by(shapes)
    assert kept < shapes
    assert len(kept) == max(1, round(0.1 * len(shapes)))
