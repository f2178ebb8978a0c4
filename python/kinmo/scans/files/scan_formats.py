"""Parsers of scan files: points or a depth image from NumPy arrays, images and PLY."""

from __future__ import annotations

import io
import re
import warnings
from dataclasses import dataclass
from lzma import LZMAError
from pathlib import Path
from tokenize import TokenError
from zipfile import BadZipFile
from zlib import error as ZlibError

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError
from kinmo.io.readers.array_reader import check_unpacked_size
from kinmo.io.readers.untrusted_files import read_bytes

F64 = NDArray[np.float64]

POINT_SUFFIXES = (".npz", ".npy", ".ply")
IMAGE_SUFFIXES = (".png", ".tif", ".tiff")
SCAN_SUFFIXES = POINT_SUFFIXES + IMAGE_SUFFIXES
MAX_SCAN_BYTES = 1 << 30
"""Most bytes of a file, and of its arrays once they are unpacked."""
MAX_PIXELS = 64_000_000
"""Most pixels of a depth image. Cameras have a few million."""
MAX_PLY_HEADER = 1 << 16
"""Number of bytes searched for the header of a PLY file."""
MIN_IMAGE_SIDE = 16
"""Least rows and columns of a depth image in an .npy file; a narrower array holds points."""

READ_ERRORS = (
    OSError,
    ValueError,
    MemoryError,
    EOFError,
    SyntaxError,
    TypeError,
    ArithmeticError,
    AttributeError,
    RuntimeError,
    TokenError,
    BadZipFile,
    LZMAError,
    ZlibError,
)
"""Errors that NumPy raises for files that are no arrays, cut off, damaged or locked, or that claim more than they hold."""


@dataclass(frozen=True, eq=False)
class DepthImage:
    """Depth image as stored in a file: one number per pixel, and the camera's intrinsics if the file has them."""

    depths: NDArray[np.generic]
    intrinsics: NDArray[np.generic] | None = None


def scan_suffix(path: Path) -> str:
    """Suffix of a file in lower case; InputError if there is no such file, or its suffix is none of `SCAN_SUFFIXES`."""
    if not path.is_file():
        raise InputError(path, f"expected a scan: {'this is a folder' if path.is_dir() else 'there is no such file'}")
    suffix = path.suffix.lower()
    if suffix not in SCAN_SUFFIXES:
        raise InputError(path, f"expected a scan: one of {', '.join(SCAN_SUFFIXES)}")
    return suffix


def parse_scan(path: Path) -> F64 | DepthImage:
    """Points [n, 3] or depth image in a scan file; InputError if it holds neither."""
    suffix = scan_suffix(path)
    if suffix == ".ply":
        return _parse_ply(path)
    return _parse_image(path) if suffix in IMAGE_SUFFIXES else _parse_arrays(path)


def _parse_arrays(path: Path) -> F64 | DepthImage:
    """The array `points`, or `depth` with `intrinsics`; other arrays are ignored."""
    try:
        loaded = np.load(io.BytesIO(_checked_content(path)), allow_pickle=False)
        if isinstance(loaded, np.ndarray):
            arrays = {"points" if loaded.ndim == 2 and min(loaded.shape) < MIN_IMAGE_SIDE else "depth": loaded}
        else:
            names = ("points",) if "points" in loaded.files else ("depth", "intrinsics")
            arrays = {name: loaded[name] for name in names if name in loaded.files}
            if not {"points", "depth"} & arrays.keys():
                raise InputError(path, f"expected points or depth, got {', '.join(loaded.files) or 'nothing'}")
    except InputError:
        raise
    except READ_ERRORS as error:
        is_pickle = isinstance(error, ValueError) and "pickle" in str(error)
        reason = "it is none, or holds objects" if is_pickle else error
        raise InputError(path, f"expected arrays of NumPy ({reason})") from None
    for name, array in arrays.items():
        if getattr(array, "dtype", np.dtype(object)).kind not in "fiu":
            raise InputError(path, "expected numbers", name)
    if "points" in arrays:
        points = np.asarray(arrays["points"], np.float64)
        if points.ndim != 2 or points.shape[1] != 3:
            raise InputError(path, f"expected [n, 3], got {list(points.shape)}", "points")
        return points
    return DepthImage(arrays["depth"], arrays.get("intrinsics"))


def _checked_content(path: Path) -> bytes:
    """The content of a file of NumPy, whose arrays are not too large."""
    raw = read_bytes(path, path.parent, MAX_SCAN_BYTES)
    if raw.startswith(b"PK"):  # NumPy looks at the content, not at the name
        check_unpacked_size(raw, path, MAX_SCAN_BYTES, ("points", "depth", "intrinsics"))
    return raw


def _parse_image(path: Path) -> DepthImage:
    from PIL import Image

    raw = read_bytes(path, path.parent, MAX_SCAN_BYTES)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            opened = Image.open(io.BytesIO(raw), formats=("PNG", "TIFF"))
        with opened as image:
            if image.width * image.height > MAX_PIXELS:
                raise InputError(path, f"expected at most {MAX_PIXELS} pixels, got {image.width} x {image.height}")
            if image.mode in ("1", "P"):
                raise InputError(path, "expected depths, got an image with a palette or of two colours")
            if image.mode == "L":
                raise InputError(path, "expected depths of 16 bits or more, got an image of 8 bits, a picture of them?")
            return DepthImage(np.asarray(image))
    except InputError:
        raise
    except (*READ_ERRORS, Image.DecompressionBombError, Image.DecompressionBombWarning) as error:
        raise InputError(path, f"expected a depth image ({error})") from None


def _parse_ply(path: Path) -> F64:
    import trimesh

    try:
        points = np.asarray(getattr(trimesh.load(path, process=False, fix_texture=False), "vertices", ()), np.float64)
    except Exception as error:  # trimesh raises whatever its parsers do
        problem = f"expected a whole PLY file whose vertices have x, y and z ({type(error).__name__}: {error})"
        raise InputError(path, problem) from None
    if points.ndim != 2 or points.shape[1:] != (3,):
        raise InputError(path, "expected a PLY file with points")
    with path.open("rb") as file:
        header = re.search(rb"^element\s+vertex\s+(-?\d+)", file.read(MAX_PLY_HEADER), re.MULTILINE)
    if header and int(header[1]) != len(points):
        raise InputError(path, f"expected {int(header[1])} points, as its header says, got {len(points)}")
    return points
