"""Minimum-volume boxes, compared with trimesh's `bounds.oriented_bounds`, one thread each.

The leaf parts of the real objects below --data, or procedural parts if there are none. No volume may exceed trimesh's by more
than a thousandth (of flat parts the area, of line-like ones the length). Parts without a box by trimesh are left out of the
times and counted. Curved parts, with more than a quarter of the surface off all axes of the file, have a row of their own.

Usage:
    python bench/obb.py [--data DIR] [--quick]
"""

from __future__ import annotations

import warnings
from pathlib import Path

from common import REAL_OBJECTS, Claim, best_time, option_parser, print_claims, print_table, ratio_claim, use_one_thread

use_one_thread()

import numpy as np
import trimesh
from numpy.typing import NDArray

from kinmo import _core
from part_meshes import MeshArrays, is_curved, load_parts

GOAL = 10.0
MAX_VOLUME_RATIO = 1.001
FLAT = 1e-9
"""Sides of a box up to this length are zero to rounding, in diagonals."""
ROUNDS = 3


def peer_extents(mesh: trimesh.Trimesh) -> NDArray[np.float64] | None:
    """Sides [3] of trimesh's box; None where it fails, as on some flat parts."""
    try:
        return np.asarray(trimesh.bounds.oriented_bounds(mesh)[1])
    except (ValueError, IndexError, np.linalg.LinAlgError):
        return None


def volume_ratio(ours: NDArray[np.float64], theirs: NDArray[np.float64]) -> float:
    """Volume of our box over theirs, without the sides that are zero to rounding in both."""
    ours, theirs = np.sort(ours), np.sort(theirs)
    spanned = np.maximum(ours, theirs) > FLAT * np.linalg.norm(theirs)
    return float(np.prod(ours[spanned]) / np.prod(theirs[spanned]))


def compare(parts: list[MeshArrays], source: str) -> Claim:
    """Print the table of the parts and return the claim."""
    found: list[tuple[float, float, float, bool]] = []
    for vertices, faces in parts:
        mesh, loaded = _core.Meshes([vertices], [faces]), trimesh.Trimesh(vertices, faces, process=False)
        _, _, half_extents = _core.fit_boxes(mesh)
        extents: list[NDArray[np.float64] | None] = []
        taken = best_time(lambda m=mesh: _core.fit_boxes(m), ROUNDS)
        peer = best_time(lambda m=loaded, e=extents: e.append(peer_extents(m)), 1)
        if extents[0] is not None:
            found.append((taken, peer, volume_ratio(2 * half_extents[0], extents[0]), is_curved(vertices, faces)))
    taken, peer, volumes, curved = (np.array(column) for column in zip(*found, strict=True))
    print(f"{len(parts)} parts; trimesh found no box of {len(parts) - len(found)}")
    rows = [
        (name, int(mask.sum()), float(taken[mask].sum()), float(peer[mask].sum()), float(peer[mask].sum() / taken[mask].sum()))
        for name, mask in (("all", np.ones(len(found), bool)), ("curved", curved))
        if mask.any()
    ]
    print_table(("parts", "number", "kinmo (s)", "trimesh (s)", "ratio"), rows)
    print(f"volume over trimesh's: median {np.median(volumes):.6f}, most {volumes.max():.6f}")
    claim = f"minimum-volume boxes compared with trimesh ({source}), s"
    agree = bool(volumes.max() <= MAX_VOLUME_RATIO)
    return ratio_claim(claim, ours=float(taken.sum()), peer=float(peer.sum()), goal=GOAL, agree=agree)


def main() -> None:
    """Compare all parts."""
    parser = option_parser(__doc__, "200 parts only")
    parser.add_argument("--data", type=Path, default=REAL_OBJECTS, help="folder of the real objects")
    options = parser.parse_args()
    warnings.filterwarnings("ignore", category=RuntimeWarning, module="trimesh")
    parts, source = load_parts(options.data, 200 if options.quick else None)
    print(source)
    print_claims(compare(parts, source))


if __name__ == "__main__":
    main()
