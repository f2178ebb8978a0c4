"""Time and memory of `kinmo predict` on one file, as a whole process, and of a second prediction in one process.

The files are cabinets of doors and drawers as GLB: one of 100,000 triangles, one of a million, and one of 300 loose pieces.

Usage:
    python bench/predict_time.py [--workspace DIR] [--quick]
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import trimesh

import kinmo
from common import option_parser, print_claims, print_table

SIZES = {"100,000 triangles": (100_000, 24), "1,000,000 triangles": (1_000_000, 24), "300 pieces": (20_000, 300)}
"""Triangles and parts of each file."""
QUICK = {"100,000 triangles": (10_000, 12)}
GOALS = {"100,000 triangles": 10.0, "1,000,000 triangles": 30.0, "300 pieces": 20.0}
"""Most seconds of the first prediction."""
GOAL_NEXT = 2.0
"""Most seconds of the next prediction of 100,000 triangles."""
PYTHON = "import sys; from kinmo.cli import main; sys.exit(main())"


def cabinet(triangles: int, parts: int) -> trimesh.Scene:
    """A carcass of five boards with `parts - 5` fronts and knobs before it, each of about the same number of triangles."""
    fronts = (parts - 5) // 2
    columns = max(1, round(fronts**0.5))
    rows = -(-fronts // columns)
    width, height = 0.5 * columns, 0.4 * rows
    boards = (
        [((width, 0.02, 0.5), (width / 2, y, 0.0)) for y in (0.0, height)]
        + [((0.02, height, 0.5), (x, height / 2, 0.0)) for x in (0.0, width)]
        + [((width, height, 0.02), (width / 2, height / 2, -0.25))]
    )
    boxes = list(boards)
    for number in range(fronts):
        x, y = 0.5 * (number % columns) + 0.25, 0.4 * (number // columns) + 0.2
        boxes += [((0.48, 0.38, 0.02), (x, y, 0.26)), ((0.03, 0.03, 0.03), (x + 0.2, y, 0.285))]
    scene = trimesh.Scene()
    for number, (size, center) in enumerate(boxes):
        mesh = trimesh.creation.box(size)
        while len(mesh.faces) * 4 <= triangles / len(boxes):
            mesh = mesh.subdivide()
        mesh.apply_translation(center)
        scene.add_geometry(mesh, node_name=f"part_{number}", geom_name=f"part_{number}")
    return scene


def whole_process(file: Path, out: Path, workspace: Path) -> tuple[float, float]:
    """Seconds and peak memory in GB of `kinmo predict FILE` in a new process."""
    command = [sys.executable, "-c", PYTHON, "predict", str(file), "-o", str(out), "-w", str(workspace), "--quiet"]
    start = time.perf_counter()
    process = subprocess.Popen(command)
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"kinmo predict {file} failed")
    return time.perf_counter() - start, usage.ru_maxrss / 1e6


def main() -> int:
    """Measure all files."""
    parser = option_parser(__doc__, "one small file")
    parser.add_argument(
        "--workspace", type=Path, default=Path("workspace"), help="workspace with networks (default: those of kinmo)"
    )
    args = parser.parse_args()
    rows: list[tuple[str, int, float, float, float]] = []
    with tempfile.TemporaryDirectory() as name:
        for title, (triangles, parts) in (QUICK if args.quick else SIZES).items():
            file = Path(name) / f"{parts}-{triangles}.glb"
            scene = cabinet(triangles, parts)
            scene.export(file)
            seconds, memory = whole_process(file, Path(name) / "out", args.workspace)
            predictor = kinmo.Predictor(args.workspace)
            times = []
            for _ in range(2):
                start = time.perf_counter()
                predictor.predict(kinmo.load(file))
                times.append(time.perf_counter() - start)
            count = int(sum(len(mesh.faces) for mesh in scene.geometry.values()))
            rows.append((title, count, seconds, times[-1], memory))
    print_table(("file", "triangles", "first, s", "next, s", "GB"), rows)
    claims = [
        {"claim": f"first prediction, {title}", "ours": first, "peer": None, "ratio": None, "goal": GOALS[title],
         "met": first <= GOALS[title]}
        for title, _, first, _, _ in rows
    ]  # fmt: skip
    following = float(np.min([row[3] for row in rows]))
    claims.append({"claim": "next prediction, 100,000 triangles", "ours": following, "peer": None, "ratio": None,
                   "goal": GOAL_NEXT, "met": following <= GOAL_NEXT})  # fmt: skip
    print_claims(*claims)
    return 0


if __name__ == "__main__":
    sys.exit(main())
