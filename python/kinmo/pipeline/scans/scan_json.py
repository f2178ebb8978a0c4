"""The JSON file of a prediction for a scan."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo._core import __version__
from kinmo.core.joint import JointKind
from kinmo.core.wording import printable_path
from kinmo.scans.object_structure import Structure
from kinmo.scans.poses.scan_estimate import ScanEstimate

SCHEMA_VERSION = 1


def scan_document(
    found: ScanEstimate, of_points: NDArray[np.integer], structure: Structure, source: Path, made_by: Mapping[str, str]
) -> dict[str, Any]:
    """A prediction as plain data.

    Args:
        found: Poses, boxes, joints and states.
        of_points: Part [n] of every point of the scan.
        structure: Parts and joints of the object.
        source: File of the scan.
        made_by: Facts about the networks.

    Returns:
        Parts and joints in the frame and units of the scan (x to the right, y down, z forward); None for unknown values.
    """
    parts = [
        {
            "id": part,
            "points": int((of_points == part).sum()),
            "inliers": _number(found.inliers[part]),
            "box": {
                "center": _list(found.centers[part]),
                "axes": _list(found.poses.rotations[part].T),
                "half_sizes": _list(found.half_extents[part]),
            },
            "pose": {
                "rotation": _list(found.poses.rotations[part]),
                "scale": _number(found.poses.scales[part]),
                "translation": _list(found.poses.translations[part]),
            },
        }
        for part in range(structure.part_count)
    ]
    has_axis = np.asarray(np.isfinite(found.directions).all(axis=1))
    joints = [
        {
            "part": row + 1,
            "parent": structure.parents[row],
            "kind": kind.value,
            "direction": _list(found.directions[row]),
            "pivot": _list(found.pivots[row]) if kind is not JointKind.PRISMATIC and has_axis[row] else None,
            "state": _number(found.states[row]),
            "turn": _number(found.turns[row]),
            "unit": "radians" if kind is JointKind.REVOLUTE else "lengths of the scan",
        }
        for row, kind in enumerate(structure.kinds)
    ]
    return {
        "schema_version": SCHEMA_VERSION,
        "kinmo": __version__,
        **made_by,
        "scan": scan_name(source),
        "parts": parts,
        "joints": joints,
    }


def scan_name(scan: Path) -> str:
    """Absolute path of a scan without links, as it is written into files."""
    return printable_path(scan.resolve())


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _list(values: NDArray[np.float64] | Sequence[float]) -> Any:
    array = np.asarray(values, np.float64)
    return array.tolist() if np.isfinite(array).all() else None
