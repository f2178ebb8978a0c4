"""Arrays from NumPy and MATLAB files, as float64. Pickled objects are never loaded."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError
from kinmo.io.readers.matlab_file import read_matlab_arrays
from kinmo.io.readers.untrusted_files import MAX_MESH_BYTES, read_bytes

Array = NDArray[np.float64]

_HDF5_MAGIC = b"\x89HDF\r\n\x1a\n"
_MATLAB_HEADER_BYTES = 512
"""Length of the header that MATLAB writes before the HDF5 data."""


def read_npz(path: Path, folder: Path, names: tuple[str, ...]) -> dict[str, Array]:
    """The arrays of these names that a NumPy archive inside `folder` has."""
    raw = read_bytes(path, folder, MAX_MESH_BYTES)
    try:
        check_unpacked_size(raw, path, MAX_MESH_BYTES, names)
        with np.load(io.BytesIO(raw), allow_pickle=False) as data:
            return {name: np.asarray(data[name], np.float64) for name in names if name in data.files}
    except InputError:
        raise
    except Exception as error:  # zipfile and NumPy raise many kinds of errors for broken archives
        raise InputError(path, f"not a NumPy archive ({type(error).__name__})") from None


def check_unpacked_size(raw: bytes, path: Path, most: int, names: tuple[str, ...]) -> None:
    """Raise InputError if the arrays of these names in a NumPy archive unpack to more than `most` bytes.

    Raises zipfile.BadZipFile for what is no archive.
    """
    with zipfile.ZipFile(io.BytesIO(raw)) as archive:
        sizes = {info.filename: info.file_size for info in archive.infolist()}
    if sum(sizes.get(f"{name}.npy", 0) for name in names) > most:
        raise InputError(path, f"unpacks to more than {most >> 20} MiB")


def read_mat(path: Path, folder: Path, names: tuple[str, ...]) -> dict[str, Array]:
    """The arrays of these names in a MATLAB file inside `folder`, with the axes in MATLAB's order.

    Files of version 7.3 are HDF5 and need the package h5py (`pip install 'kinmo[matlab]'`).
    """
    raw = read_bytes(path, folder, MAX_MESH_BYTES)
    values: Mapping[str, object]
    try:
        if raw.startswith(_HDF5_MAGIC) or raw.startswith(_HDF5_MAGIC, _MATLAB_HEADER_BYTES):
            values = _read_hdf5(raw, path, names)
        else:
            values = read_matlab_arrays(raw, names, MAX_MESH_BYTES)
        return {name: np.asarray(values[name], np.float64) for name in names}
    except InputError:
        raise
    except KeyError as error:
        raise InputError(path, "missing", str(error.args[0])) from None
    except Exception as error:  # h5py raises many kinds of errors for broken files
        raise InputError(path, f"not a MATLAB file ({type(error).__name__}: {error})") from None


def _read_hdf5(raw: bytes, path: Path, names: tuple[str, ...]) -> dict[str, object]:
    try:
        import h5py  # type: ignore[import-untyped, import-not-found, unused-ignore]
    except ImportError:
        raise InputError(path, "is HDF5 and needs the package h5py: pip install 'kinmo[matlab]'") from None
    with h5py.File(io.BytesIO(raw), "r") as file:
        found = {name: file[name][()] for name in names if name in file}
    # MATLAB writes arrays column by column, HDF5 reads them as rows
    return {name: value.T for name, value in found.items()} if raw.startswith(b"MATLAB") else found
