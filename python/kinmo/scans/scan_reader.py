"""A user's own depth scan, from whatever file it is in."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from lzma import LZMAError
from pathlib import Path
from tokenize import TokenError
from typing import Any
from zipfile import BadZipFile
from zlib import error as ZlibError

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError
from kinmo.io.atomic_files import write_bytes_atomically

F64 = NDArray[np.float64]

CLOUDS = (".npz", ".npy", ".ply")
IMAGES = (".png", ".tif", ".tiff")
ENDINGS = CLOUDS + IMAGES
LEAST_POINTS = 32
SMALLEST, LARGEST = 1e-6, 1e9
"""Longest side of the box of all points; beyond these something else than a scan is in the file."""
LONGEST_HEADER = 1 << 16
"""Bytes of a PLY file that its header is looked for in."""
NARROWEST = 16
"""Pixels across a depth image: an array of fewer rows or columns is one of points."""


READING = (
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
"""What NumPy raises for files that are no arrays, cut off, damaged, or locked, or that claim to hold more than there is."""


@dataclass(frozen=True)
class Intrinsics:
    """Of a camera: focal lengths and principal point, in pixels (the middle of the first pixel is at (0, 0))."""

    fx: float
    fy: float
    cx: float
    cy: float

    @classmethod
    def parse(cls, text: str) -> Intrinsics:
        """From "fx,fy,cx,cy". Raises InputError for anything else."""
        try:
            values = [float(value) for value in text.split(",")]
            return cls._checked(values, "--intrinsics")
        except ValueError:
            problem = f"expected fx,fy,cx,cy in pixels, fx and fy above 0, got {text!r}"
            raise InputError("--intrinsics", problem) from None

    @classmethod
    def of_matrix(cls, matrix: NDArray[np.generic], source: Path) -> Intrinsics:
        """From [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], or from (fx, fy, cx, cy).

        Raises InputError, naming `source`, for anything else.
        """
        values = np.asarray(matrix, np.float64)
        if values.shape == (3, 3):
            fx, fy, cx, cy = numbers = values[[0, 1, 0, 1], [0, 1, 2, 2]]
            is_one = np.allclose(values, [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]], rtol=0.0, atol=1e-6)
            values = numbers if is_one else np.zeros(0)
        try:
            return cls._checked(values.tolist() if values.ndim == 1 else [], str(source))
        except ValueError:
            problem = "expected the matrix [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], or fx, fy, cx, cy"
            raise InputError(source, problem, "intrinsics") from None

    @classmethod
    def _checked(cls, values: list[float], where: str) -> Intrinsics:
        if len(values) != 4 or not np.isfinite(values).all() or min(values[:2]) <= 0.0:
            raise ValueError(where)
        return cls(*values)


@dataclass(frozen=True, eq=False)
class DepthImage:
    """What a file holds of a depth image: a number a pixel, and the camera's intrinsics if it has any."""

    depths: NDArray[np.generic]
    intrinsics: NDArray[np.generic] | None = None


@dataclass(frozen=True, eq=False)
class ScanInput:
    """`points` [n, 3] in the frame of the camera: x to the right, y down, z forward.

    `places` [n] are those of the points in the file: of what it lists, or of the pixels of its image, row by row. So many more
    are `behind` it, or beside. `doubt` says what may be wrong with it.
    """

    points: F64
    places: NDArray[np.int64]
    behind: int = 0
    doubt: str | None = None


def read_scan(
    path: Path | str, intrinsics: Intrinsics | None = None, depth_scale: float | None = None, *, are_for_some: bool = False
) -> ScanInput:
    """The points of a scan.

    An .npz has `points` [n, 3], or `depth` [height, width] along z, with `intrinsics` beside it if they are not given here;
    an .npy has one of the two, a .ply points, and a .png or .tif depths. Depths are divided by `depth_scale` (1 if it is not
    given); points at no number, and those that are not before the camera (0, 0, 0 often stands for none), are left out. Raises
    InputError, naming file and field, for what is none of this or has too few points, for a scale that is not above 0, and for
    points where either is given, unless both `are_for_some` of several files.
    """
    path = Path(path)
    scale = 1.0 if depth_scale is None else depth_scale
    if not 0.0 < scale < np.inf:
        raise InputError("--depth-scale", f"expected a number above 0, got {scale:g}")
    ending = check_is_scan(path)
    found = _ply(path) if ending == ".ply" else _image(path) if ending in IMAGES else _arrays(path)
    doubt = None
    if isinstance(found, DepthImage):
        depths, camera = _depths(found, scale, path), _camera_of(found, intrinsics, path)
        points, doubt = _back_projected(depths, camera), _doubt_of(depths, camera)
    else:
        points = found
        for option, value in (("--intrinsics", intrinsics), ("--depth-scale", depth_scale)):
            if value is not None and not are_for_some:
                raise InputError(option, f"applies only to depth images; {path} holds points")
    is_known = np.isfinite(points).all(axis=1) & points.any(axis=1)
    places, behind = np.flatnonzero(is_known & (points[:, 2] > 0.0)), int(np.sum(is_known & (points[:, 2] <= 0.0)))
    points = points[places]
    if (count := count_places(points, LEAST_POINTS)) < LEAST_POINTS:
        raise InputError(path, f"expected points at {LEAST_POINTS} places before the camera (z > 0) or more, got {count}")
    across = float(np.ptp(points, axis=0).max())
    if not SMALLEST <= across <= LARGEST:
        problem = f"expected points that are {SMALLEST:g} to {LARGEST:g} apart along an axis, got {across:g}"
        raise InputError(path, problem)
    return ScanInput(points, places, behind, doubt)


def count_places(points: NDArray[np.floating], enough: int) -> int:
    """At how many places points [n, 3] are; when it is clear that these are `enough`, no more are looked for."""
    looked_at = 4 * enough
    while (count := len(np.unique(points[:looked_at], axis=0))) < enough and looked_at < len(points):
        looked_at *= 8
    return count


def write_points(path: Path, points: NDArray[np.floating], **beside: NDArray[Any]) -> None:
    """Write an .npz that `read_scan` reads, with other arrays `beside` its points [n, 3]."""
    file = io.BytesIO()
    np.savez_compressed(file, points=points, **beside)  # type: ignore[arg-type]
    write_bytes_atomically(path, file.getvalue())


def check_is_scan(path: Path) -> str:
    """The ending, in small letters, of a file that may be a scan. Raises InputError for anything else."""
    if not path.is_file():
        raise InputError(path, f"expected a scan: {'this is a folder' if path.is_dir() else 'there is no such file'}")
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        raise InputError(path, f"expected a scan: one of {', '.join(ENDINGS)}")
    return ending


def _arrays(path: Path) -> F64 | DepthImage:
    """What is in `points`, or in `depth`; whatever else the file holds is not looked at."""
    try:
        loaded = np.load(path, allow_pickle=False)
        if isinstance(loaded, np.ndarray):
            arrays = {"points" if loaded.ndim == 2 and min(loaded.shape) < NARROWEST else "depth": loaded}
        else:
            wanted = ("points",) if "points" in loaded.files else ("depth", "intrinsics")
            arrays = {name: loaded[name] for name in wanted if name in loaded.files}
            if not {"points", "depth"} & arrays.keys():
                raise InputError(path, f"expected points or depth, got {', '.join(loaded.files) or 'nothing'}")
    except READING as error:
        if isinstance(error, InputError):
            raise
        is_none = isinstance(error, ValueError) and "pickle" in str(error)
        reason = "it is none, or holds objects" if is_none else error
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


def _depths(image: DepthImage, scale: float, path: Path) -> F64:
    """A depth a pixel [height, width]; 0 for what is farther than 16 bits can tell."""
    stored = np.squeeze(image.depths)
    if stored.ndim != 2:
        raise InputError(path, f"expected one depth a pixel, [height, width], got {list(np.shape(image.depths))}", "depth")
    depths = np.asarray(stored, np.float64) / scale
    has_16_bits = (stored.dtype.kind, stored.dtype.itemsize) == ("u", 2)  # in whatever order its bytes are
    return np.where(stored == np.iinfo(np.uint16).max, 0.0, depths) if has_16_bits else depths


def _camera_of(image: DepthImage, intrinsics: Intrinsics | None, path: Path) -> Intrinsics:
    """Those that are given before those in the file."""
    if intrinsics is None and image.intrinsics is not None:
        intrinsics = Intrinsics.of_matrix(image.intrinsics, path)
    if intrinsics is None:
        raise InputError(path, "a depth image needs the camera's intrinsics: --intrinsics fx,fy,cx,cy")
    return intrinsics


def _doubt_of(depths: F64, camera: Intrinsics) -> str | None:
    """A picture that was made smaller needs other intrinsics; one that was cut out of a larger one may be right."""
    height, width = depths.shape
    if -0.5 <= camera.cx <= width - 0.5 and -0.5 <= camera.cy <= height - 0.5:
        return None
    place = f"({camera.cx:g}, {camera.cy:g})"
    return f"the principal point {place} is outside of its {width} x {height} pixels: are these the intrinsics of another?"


def _back_projected(depths: F64, camera: Intrinsics) -> F64:
    """The places [height x width, 3] of pixels, row by row."""
    rows, columns = np.indices(depths.shape)
    x, y = (columns - camera.cx) / camera.fx, (rows - camera.cy) / camera.fy
    with np.errstate(invalid="ignore"):  # no number stays none
        return np.stack([x * depths, y * depths, depths], axis=-1).reshape(-1, 3)


def _image(path: Path) -> DepthImage:
    from PIL import Image

    try:
        with Image.open(path) as image:
            if image.mode in ("1", "P"):
                raise InputError(path, "expected depths, got an image with a palette or of two colours")
            if image.mode == "L":
                raise InputError(path, "expected depths of 16 bits or more, got an image of 8 bits, a picture of them?")
            return DepthImage(np.asarray(image))
    except InputError:
        raise
    except (*READING, Image.DecompressionBombError) as error:
        raise InputError(path, f"expected a depth image ({error})") from None


def _ply(path: Path) -> F64:
    import trimesh

    try:
        points = np.asarray(getattr(trimesh.load(path, process=False, fix_texture=False), "vertices", ()), np.float64)
    except Exception as error:  # trimesh raises whatever its parsers do
        problem = f"expected a whole PLY file whose vertices have x, y and z ({type(error).__name__}: {error})"
        raise InputError(path, problem) from None
    if points.ndim != 2 or points.shape[1:] != (3,):
        raise InputError(path, "expected a PLY file with points")
    with path.open("rb") as file:
        said = re.search(rb"^element\s+vertex\s+(-?\d+)", file.read(LONGEST_HEADER), re.MULTILINE)
    if said and int(said[1]) != len(points):
        raise InputError(path, f"expected {int(said[1])} points, as its header says, got {len(points)}")
    return points
