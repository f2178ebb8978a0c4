"""Encoding of part names as hash buckets."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from kinmo.learning.name_encoding import HIDDEN, encode_names, name_buckets

BUCKETS = 512


@given(st.text())
def test_every_name_has_buckets(name: str) -> None:
    found = name_buckets(name, BUCKETS)
    assert found
    assert all(0 <= b < BUCKETS for b in found)


def test_spelling_does_not_matter() -> None:
    assert name_buckets("Drawer_Box", BUCKETS) == name_buckets("drawer box 3", BUCKETS)


def test_an_unknown_word_shares_trigrams_with_similar_words() -> None:
    known, unknown = set(name_buckets("handle", 100_000)), set(name_buckets("handlebar", 100_000))
    assert len(known & unknown) >= 4
    assert unknown != known


def test_a_name_without_letters_is_hidden() -> None:
    assert name_buckets("12_", BUCKETS) == name_buckets("", BUCKETS) == [HIDDEN]


def test_words_never_use_the_bucket_of_hidden_names() -> None:
    ids, counts = encode_names(["door", "handle", "leg"], 8)
    assert HIDDEN not in ids
    assert counts.sum() == len(ids)
