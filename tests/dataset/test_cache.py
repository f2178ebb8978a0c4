"""Results are current exactly as long as key and files are what was stored."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from kinmo.dataset.cache import FILE, Cache, cache_key

PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text(max_size=5), lambda below: st.lists(below, max_size=3), max_leaves=5
)


def stored(folder: Path) -> tuple[Cache, Path]:
    file = folder / "below" / "result.txt"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("result")
    cache = Cache(folder)
    cache.store("one", "key", [file], {"joints": 2})
    return cache, file


def test_a_stored_result_is_current_in_the_next_process(tmp_path: Path) -> None:
    stored(tmp_path)
    cache = Cache(tmp_path)
    found = cache.find("one")
    assert found is not None and found.data == {"joints": 2}
    assert cache.is_current("one", "key")
    assert not cache.is_current("one", "another key")
    assert not cache.is_current("two", "key")


def test_a_changed_file_makes_its_result_outdated(tmp_path: Path) -> None:
    cache, file = stored(tmp_path)
    file.write_text("another")
    assert not cache.is_current("one", "key")
    file.unlink()
    assert not cache.is_current("one", "key")


def test_a_file_of_the_same_size_with_other_contents_is_a_changed_one(tmp_path: Path) -> None:
    cache, file = stored(tmp_path)
    file.write_text("RESULT")
    os.utime(file, ns=(1, 1))
    assert not cache.is_current("one", "key")


def test_edited_files_may_be_accepted_but_missing_ones_never(tmp_path: Path) -> None:
    cache, file = stored(tmp_path)
    file.write_text("edited")
    assert cache.is_current("one", "key", edited=True)
    file.unlink()
    assert not cache.is_current("one", "key", edited=True)
    assert "one" in cache and "two" not in cache


def test_a_copied_folder_is_as_current_as_the_original(tmp_path: Path) -> None:
    stored(tmp_path / "original")
    shutil.copytree(tmp_path / "original", tmp_path / "copy", copy_function=shutil.copyfile)
    assert Cache(tmp_path / "copy").is_current("one", "key")


def test_a_forgotten_result_is_gone_for_good(tmp_path: Path) -> None:
    cache, _ = stored(tmp_path)
    cache.forget("one", "never stored")
    assert cache.find("one") is None
    assert Cache(tmp_path).find("one") is None


def test_a_line_cut_by_a_kill_costs_its_own_result_alone(tmp_path: Path) -> None:
    cache, _ = stored(tmp_path)
    cache.store("two", "key")
    with (tmp_path / FILE).open("r+b") as file:
        file.truncate(file.seek(0, os.SEEK_END) - 5)
    cut = Cache(tmp_path)
    assert cut.is_current("one", "key") and cut.find("two") is None
    cut.store("three", "key")
    assert Cache(tmp_path).is_current("three", "key")


def test_the_file_does_not_grow_for_ever(tmp_path: Path) -> None:
    cache = Cache(tmp_path)
    for turn in range(3000):
        cache.store("one", f"key {turn}")
    assert len((tmp_path / FILE).read_text().splitlines()) < 1100
    assert Cache(tmp_path).is_current("one", "key 2999")


@given(st.dictionaries(st.text("abc", min_size=1, max_size=3), PLAIN, max_size=4))
def test_keys_depend_on_the_inputs_and_not_on_their_order(inputs: dict[str, object]) -> None:
    assert cache_key(**inputs) == cache_key(**dict(reversed(inputs.items())))
    assert cache_key(**inputs) != cache_key(**inputs, another=1)
