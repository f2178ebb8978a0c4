"""Time to export a predicted cabinet of 30 parts, five of them concave handles, by format and kind of collision geometry.

Concave parts are divided by CoACD at the first export, and remembered.

Usage:
    python bench/export_time.py [--quick]
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np
import trimesh

import kinmo
from common import budget_claim, option_parser, print_claims, print_table
from kinmo.robot.coacd_pieces import CACHE_FOLDER
from predict_time import cabinet

PARTS, HANDLES, TRIANGLES = 30, 5, 6000
GOAL, GOAL_CONVEX = 0.2, 5.0
"""Most seconds of a URDF without and with convex pieces."""


def cabinet_with_handles(parts: int, triangles: int) -> trimesh.Scene:
    """A cabinet of `parts` parts. Some fronts have a bent handle."""
    scene = cabinet(triangles, parts - HANDLES)
    fronts = [node for node in scene.graph.nodes_geometry if scene.geometry[node].extents[0] > 0.4][-HANDLES:]
    for number, front in enumerate(fronts):
        handle = trimesh.creation.torus(0.05, 0.008, major_sections=24, minor_sections=8)
        handle.update_faces(handle.triangles_center[:, 1] > 0.0)
        turned = trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0])
        handle.apply_transform(turned)
        handle.apply_translation(scene.geometry[front].bounds.mean(axis=0) + [0.0, 0.0, 0.01])
        scene.add_geometry(handle, node_name=f"handle_{number}", geom_name=f"handle_{number}")
    return scene


def main() -> int:
    """Export in each way and print the times."""
    parser = option_parser(__doc__, "half the parts")
    args = parser.parse_args()
    rows, times = [], {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        os.environ[CACHE_FOLDER] = str(folder / "cache")
        cabinet_with_handles(PARTS // 2 if args.quick else PARTS, TRIANGLES).export(folder / "cabinet.glb")
        prediction = kinmo.Predictor(folder / "no workspace").predict(kinmo.load(folder / "cabinet.glb"))
        ways = [("urdf", "none"), ("urdf", "hull"), ("urdf", "convex"), ("urdf", "convex"), ("mjcf", "convex"), ("glb", "none")]
        for number, (form, collision) in enumerate(ways):
            title = f"{form}, {collision}" + (", remembered" if (form, collision) in ways[:number] or form == "mjcf" else "")
            start = time.perf_counter()
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                prediction.export(folder / f"out {number}", [form], collision=collision)
            times[title] = time.perf_counter() - start
            rows.append([title, len(prediction.joints), times[title]])
    print_table(["export", "joints", "seconds"], rows)
    print_claims(
        budget_claim("seconds of a URDF without collision geometry", times["urdf, none"], GOAL),
        budget_claim("seconds of a URDF with convex pieces, the first time", times["urdf, convex"], GOAL_CONVEX),
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
