"""Arrays of MATLAB files."""

from __future__ import annotations

import io
import struct
import zlib
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.io import savemat

from kinmo.io.readers.matlab_file import read_matlab_arrays

ARRAYS = {
    "solver": np.arange(12.0).reshape(3, 4) / 7.0,
    "cube": np.arange(24, dtype=np.int16).reshape(2, 3, 4),
    "faces": np.array([[1, 2, 3]], np.uint8),
    "empty": np.zeros((0, 3)),
}
MOST = 1 << 20


def saved(**options) -> bytes:
    file = io.BytesIO()
    savemat(file, {**ARRAYS, "text": "words", "complex": np.array([1j]), "cell": np.array([[1, "a"]], dtype=object)}, **options)
    return file.getvalue()


@pytest.mark.parametrize("options", [{}, {"do_compression": True}])
def test_arrays_of_any_type_are_read_in_the_order_of_matlab(options):
    found = read_matlab_arrays(saved(**options), (*ARRAYS, "text", "complex", "cell", "absent"), MOST)
    assert set(found) == set(ARRAYS)
    for name, array in ARRAYS.items():
        np.testing.assert_array_equal(found[name], array)
        assert found[name].dtype == np.float64


def test_files_of_the_other_byte_order_are_read():
    content = struct.pack(">II2I", 6, 8, 6, 0) + struct.pack(">II2i", 5, 8, 1, 2) + struct.pack(">HHcxxx", 1, 1, b"a")
    content += struct.pack(">II2d", 9, 16, 0.5, 2.0)
    data = bytes(126) + b"MI" + struct.pack(">II", 14, len(content)) + content
    assert read_matlab_arrays(data, ("a",), MOST)["a"].tolist() == [[0.5, 2.0]]


@pytest.mark.parametrize("options", [{}, {"do_compression": True}])
def test_a_file_that_is_cut_off_is_an_error_or_has_fewer_arrays(options):
    whole = saved(**options)
    for length in range(0, len(whole), 13):
        try:
            assert set(read_matlab_arrays(whole[:length], tuple(ARRAYS), MOST)) <= set(ARRAYS)
        except ValueError:
            continue


@given(st.booleans(), st.lists(st.tuples(st.integers(0, 100_000), st.integers(0, 255)), min_size=1, max_size=4))
def test_a_damaged_file_gives_arrays_or_a_value_error(compressed, changes):
    data = bytearray(saved(do_compression=compressed))
    for place, value in changes:
        data[place % len(data)] = value
    with suppress(ValueError):
        read_matlab_arrays(bytes(data), tuple(ARRAYS), MOST)


def test_a_file_that_unpacks_to_too_much_is_an_error():
    packed = zlib.compress(bytes(MOST + 1))
    data = bytes(126) + b"IM" + struct.pack("<II", 15, len(packed)) + packed
    with pytest.raises(ValueError, match="too many bytes"):
        read_matlab_arrays(data, ("a",), MOST)
