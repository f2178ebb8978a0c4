"""Arrays from NumPy and MATLAB files, never with pickles."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError
from kinmo.io.readers.untrusted_files import LARGEST_MESH, read_bytes

Array = NDArray[np.float64]


def read_npz(path: Path, folder: Path, names: tuple[str, ...]) -> dict[str, Array]:
    """Those of the arrays `names` that the file has, as float64."""
    raw = read_bytes(path, folder, LARGEST_MESH)
    found: dict[str, Array] = {}
    try:
        with zipfile.ZipFile(io.BytesIO(raw)) as archive:
            sizes = {info.filename: info.file_size for info in archive.infolist()}
        if sum(sizes.get(f"{name}.npy", 0) for name in names) > LARGEST_MESH:
            raise InputError(path, f"unpacks to more than {LARGEST_MESH >> 20} MiB")
        with np.load(io.BytesIO(raw), allow_pickle=False) as data:
            for name in names:
                if name in data.files:
                    found[name] = np.asarray(data[name], np.float64)
    except InputError:
        raise
    except Exception as error:  # whatever an unreadable archive makes zipfile and NumPy raise
        raise InputError(path, f"not a NumPy archive ({type(error).__name__})") from None
    return found


def read_mat(path: Path, folder: Path, names: tuple[str, ...]) -> dict[str, Array]:
    """The arrays `names` of a MATLAB file as float64, their axes in MATLAB's order.

    Files of version 7.3 are HDF5 and need the package h5py (`pip install 'kinmo[matlab]'`).
    """
    raw = read_bytes(path, folder, LARGEST_MESH)
    values: Mapping[str, object]
    try:
        if raw[:8] == b"\x89HDF\r\n\x1a\n" or raw[512:520] == b"\x89HDF\r\n\x1a\n":
            values = _read_hdf5(raw, path, names)
        else:
            from scipy.io import loadmat

            values = loadmat(io.BytesIO(raw), variable_names=list(names))
        return {name: np.asarray(values[name], np.float64) for name in names}
    except InputError:
        raise
    except KeyError as error:
        raise InputError(path, "missing", str(error.args[0])) from None
    except Exception as error:  # whatever an unreadable file makes the two readers raise
        raise InputError(path, f"not a MATLAB file ({type(error).__name__})") from None


def _read_hdf5(raw: bytes, path: Path, names: tuple[str, ...]) -> dict[str, object]:
    try:
        import h5py  # type: ignore[import-untyped, import-not-found, unused-ignore]
    except ImportError:
        raise InputError(path, "is HDF5 and needs the package h5py: pip install 'kinmo[matlab]'") from None
    with h5py.File(io.BytesIO(raw), "r") as file:
        found = {name: file[name][()] for name in names if name in file}
    # MATLAB writes its arrays column by column, which HDF5 reads as rows.
    return {name: value.T for name, value in found.items()} if raw.startswith(b"MATLAB") else found
