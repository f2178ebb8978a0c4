"""Minimum-volume boxes: kinmo against trimesh's `bounds.oriented_bounds`, one thread each.

    python bench/obb.py [--data data/partnet] [--quick]

The leaf parts of the real objects below `--data`, or procedural parts where there are none. First checks that no volume
exceeds trimesh's by more than a thousandth (of flat parts the area, of line-like ones the length). Parts of which trimesh
finds no box are left out of the times and counted. Curved parts, of whose surface more than a quarter faces no axis of the
file, also have a row of their own. Times are seconds of processor time.
"""

from __future__ import annotations

import os

os.environ["RAYON_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import argparse
import json
import time
import warnings
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from kinmo import _core
from parts import MeshArrays, is_curved, load_parts

GOAL, WORST_VOLUME = 10.0, 1.001
FLAT = 1e-9  # of the diagonal


def peer_extents(mesh: trimesh.Trimesh) -> NDArray[np.float64] | None:
    """Sides of trimesh's box, or None where it fails (it does on some flat parts)."""
    try:
        return np.asarray(trimesh.bounds.oriented_bounds(mesh)[1])
    except (ValueError, IndexError, np.linalg.LinAlgError):
        return None


def excess(ours: NDArray[np.float64], theirs: NDArray[np.float64]) -> float:
    """Volume of our box over theirs; of the sides that are zero to rounding in both boxes, nothing is compared."""
    ours, theirs = np.sort(ours), np.sort(theirs)
    spanned = np.maximum(ours, theirs) > FLAT * np.linalg.norm(theirs)
    return float(np.prod(ours[spanned]) / np.prod(theirs[spanned]))


def compare(parts: list[MeshArrays], rounds: int) -> dict[str, float | bool]:
    """Prints the table and returns the figures of the claim."""
    meshes = [_core.Meshes([vertices], [faces]) for vertices, faces in parts]
    ours, theirs, times, peer_times, round_ones = [], [], [], [], []
    for (vertices, faces), mesh in zip(parts, meshes, strict=True):
        rounds_taken = []
        for _ in range(rounds):
            start = time.process_time()
            _, _, half_extents = _core.fit_boxes(mesh)
            rounds_taken.append(time.process_time() - start)
        loaded = trimesh.Trimesh(vertices, faces, process=False)
        start = time.process_time()
        extents = peer_extents(loaded)
        taken = time.process_time() - start
        if extents is not None:
            ours.append(2 * half_extents[0])
            theirs.append(extents)
            times.append(min(rounds_taken))
            peer_times.append(taken)
            round_ones.append(is_curved(vertices, faces))
    volumes = np.array([excess(a, b) for a, b in zip(ours, theirs, strict=True)])
    taken, peer, curved = np.array(times), np.array(peer_times), np.array(round_ones)
    size = np.array([len(vertices) for vertices, _ in parts])
    print(f"{len(parts)} parts, {int(np.median(size))} vertices (median), {size.max()} (most)")
    print(f"trimesh found no box of {len(parts) - len(ours)} parts")
    print(f"volume over trimesh's: least {volumes.min():.4f}, median {np.median(volumes):.6f}, most {volumes.max():.6f}")
    print(f"{'':>18} {'kinmo':>10} {'trimesh':>10} {'ratio':>8}")
    print(f"{'all, s':>18} {taken.sum():>10.3f} {peer.sum():>10.3f} {peer.sum() / taken.sum():>8.1f}")
    if curved.any():
        print(f"{f'{curved.sum()} curved, s':>18} {taken[curved].sum():>10.3f} {peer[curved].sum():>10.3f}", end=" ")
        print(f"{peer[curved].sum() / taken[curved].sum():>8.1f}, volume at most {volumes[curved].max():.6f} of trimesh's")
    print(f"{'median part, ms':>18} {np.median(taken) * 1e3:>10.3f} {np.median(peer) * 1e3:>10.3f}", end=" ")
    print(f"{np.median(peer / taken):>8.1f}")
    ratio = peer.sum() / taken.sum()
    agree = bool(volumes.max() <= WORST_VOLUME)
    return {
        "ours": float(taken.sum()),
        "peer": float(peer.sum()),
        "ratio": float(ratio),
        "goal": GOAL,
        "met": bool(ratio >= GOAL) and agree,
        "worst_volume_ratio": float(volumes.max()),
    }


def main() -> None:
    """Prints the table and the JSON line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=Path("data/partnet"), help="folder of the real objects")
    parser.add_argument("--quick", action="store_true", help="200 parts only")
    arguments = parser.parse_args()
    warnings.filterwarnings("ignore", category=RuntimeWarning, module="trimesh")
    parts, source = load_parts(arguments.data, 200 if arguments.quick else None)
    print(source)
    figures = compare(parts, rounds=3)
    print(json.dumps({"claim": f"minimum-volume boxes, one thread, against trimesh ({source})", **figures}))


if __name__ == "__main__":
    main()
