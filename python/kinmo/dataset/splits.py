"""Train, validation and test split of shapes, fixed by a hash of the id on every machine."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from enum import Enum
from hashlib import blake2b

from kinmo.dataset.store import IndexEntry

PAPER_TEST_IDS = frozenset(
    (
        "12059", "12066", "12248", "11089", "11099", "11100", "11103", "11111", "11113", "29557", "29921",
        "30341", "30869", "32174",
    )
)  # fmt: skip
"""Ids of test shapes in the paper's release (refrigerator, scissors, table); they are always in the test split."""
_VALIDATION_SHARE = 0.1
_TEST_SHARE = 0.2


class Split(str, Enum):
    """Use of a labelled shape."""

    TRAIN = "train"
    VALIDATION = "validation"
    TEST = "test"


def hashed_position(shape_id: str, purpose: str) -> float:
    """Number in [0, 1) that depends on the id and the purpose alone."""
    return int.from_bytes(blake2b(f"{purpose}:{shape_id}".encode(), digest_size=8).digest(), "big") / 2.0**64


def split_of(shape_id: str) -> Split:
    """Split of a shape: a fifth test, a tenth validation, the rest train; `PAPER_TEST_IDS` are test."""
    position = hashed_position(shape_id, "split")
    if shape_id in PAPER_TEST_IDS or position < _TEST_SHARE:
        return Split.TEST
    return Split.VALIDATION if position < _TEST_SHARE + _VALIDATION_SHARE else Split.TRAIN


def fold_of(shape_id: str, folds: int = 5) -> int:
    """Fold (0 to `folds` - 1) of a cross-validation that tests a shape."""
    return int(hashed_position(shape_id, "fold") * folds)


def validation_from_training(shape_ids: Collection[str]) -> frozenset[str]:
    """Ids of a tenth of the training shapes, at least one, for validation where no validation shape exists."""
    ranked = sorted(shape_ids, key=lambda shape_id: hashed_position(shape_id, "choose"))
    return frozenset(ranked[: max(1, round(_VALIDATION_SHARE * len(ranked)))])


def leaks(unlabelled: Iterable[IndexEntry], labelled: Iterable[IndexEntry], oracle: Collection[str]) -> list[bool]:
    """True for each unlabelled shape whose pseudo labels must not be trained on.

    These are copies (same PartNet id or same geometry hash) of labelled shapes: a copy of a validation or test shape would
    carry it over to training, and a copy of a training shape has its label already. Copies of shapes with oracle labels, whose
    ids are `oracle`, are no leaks: nothing is trained on those labels.
    """
    known = [shape for shape in labelled if shape.id not in oracle]
    annotations = {shape.partnet_id for shape in known} - {None}
    hashes = {shape.geometry_hash for shape in known}
    return [shape.partnet_id in annotations or shape.geometry_hash in hashes for shape in unlabelled]
