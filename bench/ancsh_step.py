"""Time of a training step of both networks of ANCSH, on one thread or on a GPU.

A step is forward, losses, backward and Adam, without reading scans. The time is the least processor time of a step. On a GPU it
is the least time until the GPU is done, with the copy of the batch. Memory that a step frees is kept for the next one, as in
`kinmo train`; `returned` is the default behaviour of malloc.

Usage:
    python bench/ancsh_step.py [--config small] [--repeats 20] [--memory kept|returned] [--device cpu] [--quick]
"""

from __future__ import annotations

import os
import sys
import time

import torch

from common import Claim, option_parser, print_claims, print_table
from kinmo.config import AncshConfig, AncshNetworkName, load_config
from kinmo.learning.learner import adam_options
from kinmo.pipeline.network_training import MALLOC_SETTINGS, MALLOC_VARIABLE
from kinmo.scans.ancsh.ancsh_loss import ScanBatch
from kinmo.scans.ancsh.ancsh_training import AncshLearner

PARTS = 3
"""Number of parts of the object."""
NETWORKS: tuple[AncshNetworkName, ...] = ("ancsh", "npcs")


def random_batch(config: AncshConfig) -> ScanBatch:
    """A batch of scans with random points and targets."""
    frames, points = config.batch_frames, config.points
    known = torch.rand(frames, points)
    return ScanBatch(
        points=torch.rand(frames, points, 3) - 0.5,
        parts=torch.randint(PARTS, (frames, points)),
        npcs=torch.rand(frames, points, 3),
        naocs=torch.rand(frames, points, 3),
        joints=torch.randint(PARTS, (frames, points)),
        heatmap=known,
        toward=torch.nn.functional.normalize(torch.randn(frames, points, 3), dim=-1),
        axes=torch.nn.functional.normalize(torch.randn(frames, points, 3), dim=-1),
        has_pivot=torch.ones(frames, points),
        half_sizes=torch.rand(frames, PARTS, 3) + 0.1,
        pivots=torch.rand(frames, PARTS - 1, 3),
        is_line=torch.ones(frames, PARTS - 1),
    )


def step_seconds(config: AncshConfig, which: AncshNetworkName, repeats: int, device: str) -> float:
    """Least time of a step: processor time, or on a GPU the time until it is done."""
    torch.manual_seed(0)
    learner, batch = AncshLearner(config, which, PARTS, PARTS).to(device), random_batch(config)
    now = time.process_time if device == "cpu" else time.perf_counter
    optimizer = torch.optim.Adam(learner.network.parameters(), **adam_options(config.training))
    times = []
    for _ in range(repeats):
        start = now()
        optimizer.zero_grad()
        loss = learner.training_step(batch.to(device))
        loss.backward()
        optimizer.step()
        loss.item()  # waits for the device
        times.append(now() - start)
    return min(times)


def main() -> None:
    """Time both networks of a configuration."""
    parser = option_parser(__doc__, "3 steps")
    parser.add_argument("--config", default="small", help="name of the configuration")
    parser.add_argument("--repeats", type=int, default=20, help="number of steps")
    parser.add_argument("--memory", choices=("kept", "returned"), default="kept", help="treatment of freed memory")
    parser.add_argument("--device", default="cpu", help="cpu or cuda")
    arguments = parser.parse_args()
    wanted = MALLOC_SETTINGS if arguments.memory == "kept" else ""
    if os.environ.get(MALLOC_VARIABLE) != wanted:  # both variables are read when a process starts
        os.execve(sys.executable, [sys.executable, *sys.argv], os.environ | {MALLOC_VARIABLE: wanted, "RAYON_NUM_THREADS": "1"})
    torch.set_num_threads(1)
    config, repeats = load_config(arguments.config).ancsh, 3 if arguments.quick else arguments.repeats
    where = f"memory {arguments.memory}" if arguments.device == "cpu" else arguments.device
    print(f"{arguments.config}, {config.batch_frames} frames of {config.points} points, {where}")
    claims: list[Claim] = []
    rows = []
    for which in NETWORKS:
        seconds = step_seconds(config, which, repeats, arguments.device)
        rows.append((which, 1e3 * seconds, config.batch_frames / seconds))
        claim = f"a training step of {which} ({arguments.config}, {where}), ms"
        claims.append({"claim": claim, "ours": 1e3 * seconds, "peer": None, "ratio": None, "goal": None, "met": None})
    print_table(("network", "step (ms)", "frames a second"), rows)
    print_claims(*claims)


if __name__ == "__main__":
    main()
