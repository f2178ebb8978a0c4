"""Text for messages."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinmo.core.wording import MAX_TEXT_LENGTH, clean_text, counted, duration, printable_path


def test_a_single_object_has_no_plural() -> None:
    assert [counted(count, "object") for count in (0, 1, 2)] == ["0 objects", "1 object", "2 objects"]


@pytest.mark.parametrize(("seconds", "text"), [(0.1, "1 s"), (45, "45 s"), (720, "12 min"), (5400, "1.5 h")])
def test_a_duration_has_the_unit_that_people_use(seconds: float, text: str) -> None:
    assert duration(seconds) == text


@given(st.text())
def test_clean_text_is_one_short_printable_line(text: str) -> None:
    cleaned = clean_text(text)
    assert cleaned.isprintable()
    assert len(cleaned.encode("utf-8").decode("utf-8")) <= MAX_TEXT_LENGTH


def test_a_path_with_invalid_bytes_can_be_printed() -> None:
    assert printable_path("a/\udcffb") == "a/\\xffb"
