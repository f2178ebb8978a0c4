"""Long calls let other threads run, and Ctrl-C stops them between two batches."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

# Every call would take long. Another thread runs for a while meanwhile, and then presses Ctrl-C. (`move_points` never takes
# long: its result would not fit into memory.)
SCRIPT = """
import json, os, signal, threading, time
import numpy as np
from scipy.spatial.transform import Rotation
from kinmo import _core

signal.signal(signal.SIGINT, signal.default_int_handler)  # whoever started the tests may have had it ignored
rng = np.random.default_rng(0)
faces = np.arange(3000, dtype=np.uint32).reshape(-1, 3)
strip = np.arange(98, dtype=np.uint32)[:, None] + np.arange(3, dtype=np.uint32)
tangle = _core.Meshes([rng.uniform(size=(300, 3)) for _ in range(2)], [faces[:100]] * 2)
often = [[0, 1]] * 300_000
many = np.broadcast_to(np.array([0, 1], np.uint32), (300_000, 2))
joints = np.zeros(100_000, np.uint8), np.eye(3)[np.arange(100_000) % 3], np.zeros((100_000, 3))
turn = Rotation.from_rotvec([0.3, 0.5, 0.7]).as_matrix()
box, turned = (
    [np.tile(array, (500_000, *[1] * array.ndim)) for array in (np.zeros(3), axes, np.ones(3))] for axes in (np.eye(3), turn)
)
parts = 60_000
cloud, rows = rng.uniform(size=(20 * parts, 3)), np.arange(0, 20 * parts + 1, 20)
up = np.tile([0.0, 0.0, 1.0], (parts // 2, 1))
ties = np.arange(parts, dtype=np.uint32).reshape(-1, 2), np.zeros(parts // 2, np.uint8), up
poses = np.tile(np.eye(3), (parts, 1, 1)), np.ones(parts), np.zeros((parts, 3))
objects = np.arange(0, parts + 1, 2)
known = np.tile([0.0, 1.0], (parts // 2, 1)), np.ones(parts, bool)
search = {"hypotheses": 1000, "threshold": 0.1, "seed": 0}
calls = {
    "render": lambda: _core.render(
        tangle, np.tile(np.eye(4), (40_000, 2, 1, 1)), (32, 32), np.full(2, 16.0), np.full(2, 16.0), near=0.01, far=9.0
    ),
    "manhattan_frames": lambda: _core.manhattan_frames(
        rng.uniform(size=(20_000, 100, 3)).astype(np.float32), np.ones((20_000, 100), bool)
    ),
    "nearest_neighbours": lambda: _core.nearest_neighbours(rng.uniform(size=(20_000, 500, 3)).astype(np.float32), 8),
    "neighbour_argmax": lambda: _core.neighbour_argmax(
        np.zeros((200, 100, 1024), np.float32), np.zeros((200, 100, 256), np.int64)
    ),
    "group_points": lambda: _core.group_points(rng.uniform(size=(4_000, 1000, 3)).astype(np.float32), 300, 0.2, 32),
    "find_similarities": lambda: _core.find_similarities(cloud, cloud, rows, **search),
    "fit_constrained_poses": lambda: _core.fit_constrained_poses(
        cloud, cloud[::-1].copy(), rows, *ties, *poses, frames=objects, threshold=9.0
    ),
    "refine_poses": lambda: _core.refine_poses(cloud, cloud, rows, *ties, *known, *poses, frames=objects, threshold=9.0),
    "find_constrained_poses": lambda: _core.find_constrained_poses(cloud, cloud, rows, *ties, np.ones(parts), **search),
    "adjust_amodal_boxes": lambda: _core.adjust_amodal_boxes(
        cloud, rows[::20], np.zeros(20 * parts, int), np.zeros((parts // 20, 3)), poses[2][::20] + 5.0, poses[0][::20],
        np.ones((parts // 20, 3)), frames=np.arange(parts // 20 + 1)
    ),
    "Meshes": lambda: _core.Meshes([np.broadcast_to(np.zeros(3), (1_000_000, 3))] * 3000, [faces] * 3000),
    "sample_surface": lambda: _core.sample_surface(_core.Meshes([np.eye(3)] * 900, [faces[:1]] * 900), 5_000, blue_noise=True),
    "fit_boxes": lambda: _core.fit_boxes(tangle, often),
    "fit_symmetric_boxes": lambda: _core.fit_symmetric_boxes(tangle, often),
    "find_symmetries": lambda: _core.find_symmetries(tangle, often),
    "find_round_pieces": lambda: _core.find_round_pieces(_core.Meshes([rng.uniform(size=(100, 3))] * 5_000, [strip] * 5_000)),
    "part_distances": lambda: _core.part_distances(_core.Meshes([np.eye(3)] * 20_000, [faces[:1]] * 20_000), max_distance=0.0),
    "interaction_regions": lambda: _core.interaction_regions(rng.normal(size=(2, 500, 3)), many),
    "sweep": lambda: _core.sweep(tangle, [0], [1], *joints, np.full(100_000, -1.0), np.ones(100_000)),
    "box_iou": lambda: _core.box_iou(*box, *turned),
    "closest_points": lambda: _core.closest_points(tangle, [0, 1], rng.uniform(size=(3_000_000, 3))),
}

def press_after_a_while():
    started.wait()
    for _ in range(10):
        time.sleep(0.01)
    os.kill(os.getpid(), signal.SIGINT)

outcomes = {}
for name, call in calls.items():
    started = threading.Event()
    presser = threading.Thread(target=press_after_a_while)
    presser.start()
    try:
        started.set()
        call()
        outcomes[name] = "finished"
        presser.join()
        time.sleep(1)  # what is pressed too late comes here
    except KeyboardInterrupt:
        outcomes.setdefault(name, "interrupted")
    presser.join()
print(json.dumps(outcomes))
"""


@pytest.fixture(scope="module")
def outcomes() -> dict[str, str]:
    """Outcome of every call."""
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return dict(json.loads(done.stdout))


@pytest.mark.parametrize(
    "name",
    [
        "Meshes",
        "sample_surface",
        "fit_boxes",
        "fit_symmetric_boxes",
        "find_symmetries",
        "find_round_pieces",
        "part_distances",
        "interaction_regions",
        "sweep",
        "box_iou",
        "closest_points",
        "render",
        "manhattan_frames",
        "nearest_neighbours",
        "neighbour_argmax",
        "group_points",
        "find_similarities",
        "fit_constrained_poses",
        "refine_poses",
        "find_constrained_poses",
        "adjust_amodal_boxes",
    ],
)
def test_ctrl_c_stops_a_long_call_while_another_thread_runs(outcomes: dict[str, str], name: str) -> None:
    assert outcomes[name] == "interrupted"
