"""A training step of both networks of ANCSH, on one thread: forward, losses, backward and Adam, without reading scans.

    python bench/ancsh_step.py [--config small] [--repeats 20] [--memory kept|returned] [--device cpu]

Prints the least processor time of a step and the frames a second that it makes; on another device than the processor, the least
time until that has done it, the batch's way there included. Memory that a step frees is kept for the next one, as `kinmo train`
has it where networks are trained side by side; `returned` is what malloc does by itself. To compare two states of the code, run
it in both, one after the other.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time

import torch

from kinmo.config import AncshConfig, AncshNetworkName, load_config
from kinmo.learning.training_loop import adam_options
from kinmo.pipeline.network_training import KEPT, TUNABLES
from kinmo.scans.ancsh.ancsh_loss import ScanBatch
from kinmo.scans.ancsh.ancsh_training import AncshLearner

PARTS = 3
NETWORKS: tuple[AncshNetworkName, ...] = ("ancsh", "npcs")


def random_batch(config: AncshConfig) -> ScanBatch:
    """Scans of an object of `PARTS` parts, all of whose points and answers are random."""
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
    """The least processor time of a step, or on another device the least time until that has done it."""
    torch.manual_seed(0)
    learner, batch = AncshLearner(config, which, PARTS, PARTS).to(device), random_batch(config)
    now = time.process_time if device == "cpu" else time.perf_counter
    learner.log = lambda *_, **__: None  # type: ignore[method-assign] # what is logged goes to a trainer, and here is none
    optimizer = torch.optim.Adam(learner.network.parameters(), **adam_options(config.training))
    times = []
    for _ in range(repeats):
        start = now()
        optimizer.zero_grad()
        loss = learner.training_step(batch.to(device), 0)
        loss.backward()
        optimizer.step()
        loss.item()  # waits for the device
        times.append(now() - start)
    return min(times)


def main() -> None:
    """Both networks of a configuration."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--config", default="small")
    parser.add_argument("--repeats", type=int, default=20)
    parser.add_argument("--memory", choices=("kept", "returned"), default="kept")
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--quick", action="store_true", help="3 steps")
    arguments = parser.parse_args()
    wanted = KEPT if arguments.memory == "kept" else ""
    if os.environ.get(TUNABLES) != wanted:  # it is read when a process starts, as is how many threads the core has
        os.execve(sys.executable, [sys.executable, *sys.argv], os.environ | {TUNABLES: wanted, "RAYON_NUM_THREADS": "1"})
    torch.set_num_threads(1)
    config, repeats = load_config(arguments.config).ancsh, 3 if arguments.quick else arguments.repeats
    for which in NETWORKS:
        seconds = step_seconds(config, which, repeats, arguments.device)
        where = f"memory {arguments.memory}" if arguments.device == "cpu" else arguments.device
        how = f"{arguments.config}, {config.batch_frames} frames of {config.points} points, {where}"
        claim = f"a step of {which} ({how}), ms"
        print(f"{claim}: {1e3 * seconds:.0f}, {config.batch_frames / seconds:.0f} frames a second")
        print(json.dumps({"claim": claim, "ours": 1e3 * seconds, "peer": None, "ratio": None, "goal": None, "met": None}))


if __name__ == "__main__":
    main()
