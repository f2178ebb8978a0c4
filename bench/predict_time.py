"""Time and memory of `kinmo predict` on one file, as a whole process, and of a second prediction in one process.

The files are GLB: cabinets of doors and drawers of 100,000 triangles, of a million, and of 300 loose pieces, and a board of 60
bowls. Bowls are concave, so that their collision geometry takes most of the time. Nothing is remembered of an earlier run.

Usage:
    python bench/predict_time.py [--workspace DIR] [--quick]
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np
import trimesh

import kinmo
from common import option_parser, print_claims, print_table

GOALS = {"100,000 triangles": 10.0, "1,000,000 triangles": 30.0, "300 pieces": 20.0, "60 bowls": 20.0}
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


def bowls(triangles: int, parts: int) -> trimesh.Scene:
    """A board with `parts - 1` bowls of different heights on it."""
    columns = max(1, round((parts - 1) ** 0.5))
    sections = max(6, round((triangles / (parts - 1) / 2) ** 0.5))
    angles = np.linspace(0.0, np.pi / 2, sections // 2)
    outer = np.stack([np.sin(angles), 1.0 - np.cos(angles)], axis=1)
    profile = np.concatenate([outer, (0.9 * outer + (0.0, 0.1))[::-1]])
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.box((3.0 * columns, 3.0 * columns, 0.2)), node_name="board", geom_name="board")
    for number in range(parts - 1):
        bowl = trimesh.creation.revolve(profile * (1.0, 0.5 + number / parts), sections=sections)
        place = 3.0 * (np.array([number % columns, number // columns]) - 0.5 * (columns - 1))
        bowl.apply_translation((*place, 0.1))
        scene.add_geometry(bowl, node_name=f"bowl_{number}", geom_name=f"bowl_{number}")
    scene.apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2, (1, 0, 0)))
    return scene


FILES = {
    "100,000 triangles": partial(cabinet, 100_000, 24),
    "1,000,000 triangles": partial(cabinet, 1_000_000, 24),
    "300 pieces": partial(cabinet, 20_000, 300),
    "60 bowls": partial(bowls, 80_000, 61),
}
"""Maker of the scene of each file."""
QUICK = {"100,000 triangles": partial(cabinet, 10_000, 12)}


def whole_process(file: Path, out: Path, workspace: Path) -> tuple[float, float]:
    """Seconds and peak memory in GB of `kinmo predict FILE` in a new process."""
    command = [sys.executable, "-c", PYTHON, "predict", str(file), "-o", str(out), "-w", str(workspace), "--quiet"]
    start = time.perf_counter()
    process = subprocess.Popen(command, env={**os.environ, "KINMO_CACHE": str(out.with_name("cache"))})
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
        for place, (title, made) in enumerate((QUICK if args.quick else FILES).items()):
            file = Path(name) / f"{place}.glb"
            scene = made()
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
    following = rows[0][3]
    claims.append({"claim": "next prediction, 100,000 triangles", "ours": following, "peer": None, "ratio": None,
                   "goal": GOAL_NEXT, "met": following <= GOAL_NEXT})  # fmt: skip
    print_claims(*claims)
    return 0


if __name__ == "__main__":
    sys.exit(main())
