"""Which shapes train, which choose and which test: fixed by a hash of the id, the same everywhere and for ever."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from enum import Enum
from hashlib import blake2b
from typing import Protocol

PAPER_TEST_IDS = frozenset(
    (
        "12059", "12066", "12248", "11089", "11099", "11100", "11103", "11111", "11113", "29557", "29921",
        "30341", "30869", "32174",
    )
)  # fmt: skip
"""Test ids of the paper's release (refrigerator, scissors, table), which are always test."""
_VALIDATION_SHARE = 0.1
_TEST_SHARE = 0.2


class Split(str, Enum):
    TRAIN = "train"
    VALIDATION = "validation"
    TEST = "test"


class Identified(Protocol):
    """What tells copies of a shape: its PartNet annotation, if it has one, and a hash of its geometry."""

    @property
    def id(self) -> str: ...

    @property
    def partnet_id(self) -> str | None: ...

    @property
    def geometry_hash(self) -> str: ...


def _position(shape_id: str, purpose: str) -> float:
    """A number in [0, 1) that depends on the id and the purpose alone."""
    return int.from_bytes(blake2b(f"{purpose}:{shape_id}".encode(), digest_size=8).digest(), "big") / 2.0**64


def split_of(shape_id: str) -> Split:
    """The split of a shape: a fifth test, a tenth validation, the rest train; `PAPER_TEST_IDS` are test."""
    position = _position(shape_id, "split")
    if shape_id in PAPER_TEST_IDS or position < _TEST_SHARE:
        return Split.TEST
    return Split.VALIDATION if position < _TEST_SHARE + _VALIDATION_SHARE else Split.TRAIN


def fold_of(shape_id: str, folds: int = 5) -> int:
    """The fold, 0 to `folds` - 1, in which a shape is tested in a cross-validation."""
    return int(_position(shape_id, "fold") * folds)


def is_validation_in_fold(shape_id: str, fold: int, folds: int = 5) -> bool:
    """Whether a shape that fold `fold` does not test is kept from training, to choose the model by."""
    return fold_of(shape_id, folds) != fold and _position(shape_id, f"validation {fold}") < _VALIDATION_SHARE


def kept_to_choose_by(shape_ids: Collection[str]) -> frozenset[str]:
    """A tenth of some shapes, at least one, by a hash: where none of a kind that is to be trained on is a validation shape."""
    ranked = sorted(shape_ids, key=lambda shape_id: _position(shape_id, "choose"))
    return frozenset(ranked[: max(1, round(_VALIDATION_SHARE * len(ranked)))])


def within_share(shapes: Iterable[tuple[str, str]], share: float) -> list[bool]:
    """For every shape, given as its id and its category, whether it is among the `share` of labelled ones.

    Of each category that share is kept, at least one shape; a smaller share is part of any larger one.
    """
    known = list(shapes)
    ranked: dict[str, list[tuple[float, str]]] = {}
    for shape_id, category in known:
        ranked.setdefault(category, []).append((_position(shape_id, "share"), shape_id))
    kept = {
        (shape_id, category)
        for category, ids in ranked.items()
        for _, shape_id in sorted(ids)[: max(1, round(share * len(ids)))]
    }
    return [shape in kept for shape in known]


def leaks(unlabelled: Iterable[Identified], labelled: Iterable[Identified], hidden: Collection[str]) -> list[bool]:
    """For every unlabelled shape, whether a pseudo label for it must not be trained on.

    It must not if the shape is a copy (same PartNet id, or same geometry hash) of a labelled one: a copy of a validation or
    test shape would carry it over to training, and a copy of a training shape has its label already. Excepted are copies of
    the training shapes whose ids are in `hidden`: those whose label is kept from training by the ratio of labelled data.
    """
    known = [shape for shape in labelled if shape.id not in hidden]
    annotations = {shape.partnet_id for shape in known} - {None}
    hashes = {shape.geometry_hash for shape in known}
    return [shape.partnet_id in annotations or shape.geometry_hash in hashes for shape in unlabelled]
