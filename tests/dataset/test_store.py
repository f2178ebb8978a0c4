"""Prepared shapes and their index come back from disk as they were."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import fields, replace

import numpy as np
import pytest
from datasets import mobility, write_partnet, write_partnet_mobility

from kinmo.core.errors import InputError
from kinmo.dataset.store import INDEX, IndexEntry, PreparedStore, file_name, read_prepared, to_bytes, write_index
from kinmo.features.shape_preparation import prepare_shape
from kinmo.io.readers import read_partnet, read_partnet_mobility


@pytest.fixture(scope="module")
def labelled(tmp_path_factory):
    bodies = mobility()
    bodies[2]["jointData"]["limit"]["noLimit"] = True
    folder = write_partnet_mobility(tmp_path_factory.mktemp("store") / "4711", bodies)
    return prepare_shape(read_partnet_mobility(folder), points=64)


@pytest.fixture(scope="module")
def unlabelled(tmp_path_factory):
    return prepare_shape(read_partnet(write_partnet(tmp_path_factory.mktemp("store") / "4711")), points=64)


def plain(value):
    """Nested data in which arrays, and everything made of them, compare by value."""
    if isinstance(value, np.ndarray):
        return (value.dtype.str, value.shape, value.tobytes())
    if isinstance(value, tuple):
        return tuple(map(plain, value))
    if isinstance(value, dict):
        return {name: plain(item) for name, item in value.items()}
    if hasattr(value, "__dataclass_fields__"):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    return value


@pytest.mark.parametrize("name", ["labelled", "unlabelled"])
def test_a_shape_comes_back_as_it_was(tmp_path, request, name):
    shape = request.getfixturevalue(name)
    path = tmp_path / "shape.safetensors"
    path.write_bytes(to_bytes(shape))
    assert plain(read_prepared(path)) == plain(shape)


def test_the_same_shape_gives_the_same_bytes(tmp_path, labelled):
    data = to_bytes(labelled)
    (tmp_path / "a").write_bytes(data)
    assert to_bytes(read_prepared(tmp_path / "a")) == data


def test_arrays_of_candidate_features_are_kept_by_name(tmp_path, labelled):
    shape = replace(labelled, candidate_features={"features": np.arange(6, dtype=np.float32).reshape(2, 3)})
    (tmp_path / "a").write_bytes(to_bytes(shape))
    np.testing.assert_array_equal(read_prepared(tmp_path / "a").candidate_features["features"], [[0, 1, 2], [3, 4, 5]])


def test_a_file_that_is_cut_or_garbled_is_refused(tmp_path, labelled):
    data = to_bytes(labelled)
    rng = np.random.default_rng(0)
    path = tmp_path / "shape.safetensors"
    for keep in [0, 4, 8, 100, *rng.integers(0, len(data), 20).tolist(), len(data) - 1]:
        path.write_bytes(data[:keep])
        with pytest.raises(InputError, match=r"shape\.safetensors"):
            read_prepared(path)
    for _ in range(200):
        garbled = bytearray(data)
        garbled[int(rng.integers(0, 4000))] = int(rng.integers(0, 256))
        path.write_bytes(garbled)
        with suppress(InputError):
            read_prepared(path)
    with pytest.raises(InputError, match="run kinmo prepare again"):
        read_prepared(tmp_path / "missing")


def entry(layout: str, shape_id: str) -> IndexEntry:
    return IndexEntry(
        shape_id, layout, "Box", file_name(layout, shape_id), "/x", "key", None, "hash", 3, 2, 1, True, ("repaired",)
    )


def test_an_index_is_sorted_and_comes_back(tmp_path):
    entries = [entry("partnet", "b"), entry("partnet_mobility", "a"), entry("partnet", "é \U0001f600"), entry("partnet", "a")]
    write_index(tmp_path, entries)
    text = (tmp_path / INDEX).read_bytes()
    write_index(tmp_path, entries[::-1])
    assert (tmp_path / INDEX).read_bytes() == text
    store = PreparedStore(tmp_path)
    assert sorted(entries, key=lambda e: (e.layout, e.id)) == list(store.entries)
    assert len(store) == 4


@pytest.mark.parametrize("text", ["{", "[1]\n", '{"id": "a"}\n', "\xff"])
def test_an_index_that_is_missing_or_garbled_is_refused(tmp_path, text):
    with pytest.raises(InputError, match="kinmo prepare"):
        PreparedStore(tmp_path)
    (tmp_path / INDEX).write_bytes(text.encode("latin-1"))
    with pytest.raises(InputError, match="index"):
        PreparedStore(tmp_path)


def test_a_shape_has_its_file_in_the_folder_of_its_layout():
    assert file_name("partnet", "a/b") == "partnet/a%2Fb.safetensors"
