"""Reader of users' depth scans, from point files and depth images."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError
from kinmo.io.atomic_files import write_bytes_atomically
from kinmo.scans.files.camera_intrinsics import Intrinsics
from kinmo.scans.files.scan_formats import DepthImage, parse_scan

F64 = NDArray[np.float64]

MIN_POINTS = 32
"""Least number of distinct points of a scan."""
MIN_EXTENT, MAX_EXTENT = 1e-6, 1e9
"""Longest side of the points' box; beyond these the file holds something other than a scan."""


@dataclass(frozen=True, eq=False)
class ScanInput:
    """A user's scan.

    Attributes:
        points: Points [n, 3] in the camera frame: x to the right, y down, z forward.
        indices: Index [n] of each point in the file: in its list of points, or among the pixels of its image, row by row.
        behind_count: Number of left out points that are not before the camera.
        warning: Possible fault of the scan, or None.
    """

    points: F64
    indices: NDArray[np.int64]
    behind_count: int = 0
    warning: str | None = None


def read_scan(
    path: Path | str,
    intrinsics: Intrinsics | None = None,
    depth_scale: float | None = None,
    *,
    ignore_unused_options: bool = False,
) -> ScanInput:
    """Read a scan.

    An .npz holds `points` [n, 3], or `depth` [height, width] along z and maybe `intrinsics`. An .npy holds points or depths, a
    .ply points, and a .png or .tif depths. Points that are not finite, not before the camera, or at (0, 0, 0), are left out.

    Args:
        path: The file.
        intrinsics: Intrinsics of a depth image. They override those in the file.
        depth_scale: Divisor of the stored depths. Default: 1.
        ignore_unused_options: True to ignore the two options for points, to which they do not apply. False raises an error.

    Returns:
        The points in the camera frame.

    Raises:
        InputError: If the file is no scan or has too few points, or if an option is wrong. It names the file and the field.

    Example:
        >>> scan = read_scan("fridge.png", Intrinsics(525.0, 525.0, 319.5, 239.5), depth_scale=1000.0)
        >>> scan.points.shape
        (187402, 3)
    """
    path = Path(path)
    scale = 1.0 if depth_scale is None else depth_scale
    if not 0.0 < scale < np.inf:
        raise InputError("--depth-scale", f"expected a number above 0, got {scale:g}")
    parsed = parse_scan(path)
    if isinstance(parsed, DepthImage):
        points, warning = _from_image(parsed, scale, intrinsics, path)
    else:
        points, warning = parsed, None
        for option, value in (("--intrinsics", intrinsics), ("--depth-scale", depth_scale)):
            if value is not None and not ignore_unused_options:
                raise InputError(option, f"applies only to depth images; {path} holds points")
    is_known = np.isfinite(points).all(axis=1) & points.any(axis=1)
    indices, behind = np.flatnonzero(is_known & (points[:, 2] > 0.0)), int(np.sum(is_known & (points[:, 2] <= 0.0)))
    points = points[indices]
    if (count := count_distinct_points(points, MIN_POINTS)) < MIN_POINTS:
        raise InputError(path, f"expected points at {MIN_POINTS} places before the camera (z > 0) or more, got {count}")
    extent = float(np.ptp(points, axis=0).max())
    if not MIN_EXTENT <= extent <= MAX_EXTENT:
        problem = f"expected points that are {MIN_EXTENT:g} to {MAX_EXTENT:g} apart along an axis, got {extent:g}"
        raise InputError(path, problem)
    return ScanInput(points, indices, behind, warning)


def count_distinct_points(points: NDArray[np.floating], enough: int) -> int:
    """Number of distinct points among points [n, 3]; counting stops once there are `enough`."""
    checked = 4 * enough
    while (count := len(np.unique(points[:checked], axis=0))) < enough and checked < len(points):
        checked *= 8
    return count


def write_points(path: Path, points: NDArray[np.floating], **arrays: NDArray[Any]) -> None:
    """Write points [n, 3] and other arrays to an .npz that `read_scan` reads."""
    file = io.BytesIO()
    np.savez_compressed(file, points=points, **arrays)  # type: ignore[arg-type]
    write_bytes_atomically(path, file.getvalue())


def _from_image(image: DepthImage, scale: float, camera: Intrinsics | None, path: Path) -> tuple[F64, str | None]:
    """Points [height x width, 3] of the pixels, row by row, and a warning if the principal point is outside the image.

    Resized images need other intrinsics, cropped ones may be right. The given intrinsics override those of the file.
    """
    stored = np.squeeze(image.depths)
    if stored.ndim != 2:
        raise InputError(path, f"expected one depth a pixel, [height, width], got {list(np.shape(image.depths))}", "depth")
    depths = np.asarray(stored, np.float64) / scale
    if (stored.dtype.kind, stored.dtype.itemsize) == ("u", 2):  # in either byte order; the largest number is out of range
        depths = np.where(stored == np.iinfo(np.uint16).max, 0.0, depths)
    if camera is None and image.intrinsics is not None:
        camera = Intrinsics.from_matrix(image.intrinsics, path)
    if camera is None:
        raise InputError(path, "a depth image needs the camera's intrinsics: --intrinsics fx,fy,cx,cy")
    height, width = depths.shape
    warning: str | None = None
    if not (-0.5 <= camera.cx <= width - 0.5 and -0.5 <= camera.cy <= height - 0.5):
        place, size = f"({camera.cx:g}, {camera.cy:g})", f"{width} x {height}"
        warning = f"the principal point {place} is outside of its {size} pixels: are these the intrinsics of another?"
    rows, columns = np.indices(depths.shape)
    x, y = (columns - camera.cx) / camera.fx, (rows - camera.cy) / camera.fy
    with np.errstate(invalid="ignore"):  # NaN stays NaN
        return np.stack([x * depths, y * depths, depths], axis=-1).reshape(-1, 3), warning
