"""A training loop for every network: resumable at any moment, quiet, with the best epoch chosen on validation.

Everything random in a step is drawn from (seed, epoch, step), and every epoch ends with a checkpoint. A run that was killed
anywhere and started again ends with the weights of a run that was not.
"""

from __future__ import annotations

import csv
import io
import json
import math
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol, cast

import numpy as np
import torch
from torch import Tensor, nn
from torch.optim.swa_utils import AveragedModel, get_ema_multi_avg_fn

from kinmo.core.errors import InputError
from kinmo.io.atomic_files import write_bytes_atomically, write_json_atomically, write_text_atomically
from kinmo.learning.learner import MONITOR, Learner, mixed_dtype
from kinmo.learning.model_folder import METRICS, METRICS_TABLE
from kinmo.learning.weights import pick_device

CHECKPOINTS = ("last.ckpt", "previous.ckpt")
BEST = "best.pt"
WARM_UP_STEPS = 10
"""A moving average forgets its first steps faster: at step t the decay is at most (1 + t) / (WARM_UP_STEPS + t)."""


class TrainingData(Protocol):
    """Batches for `fit`. A batch has a method `to(device)` that returns the same batch on that device."""

    def training_batches(self, epoch: int, rng: np.random.Generator) -> Iterable[Any]:
        """Batches of one epoch. All randomness must come from `rng`."""

    def validation_batches(self) -> Iterable[Any]:
        """The same batches every time; at least one."""


@dataclass(frozen=True)
class Progress:
    """State after an epoch: `epoch` of `epochs` are done; `metrics` are those of the last one."""

    epoch: int
    epochs: int
    metrics: Mapping[str, float]


@dataclass(frozen=True)
class FitResult:
    """Index in `history` of the epoch whose weights were kept, its `MONITOR`, and the metrics of every epoch."""

    best_epoch: int
    best_error: float
    history: tuple[Mapping[str, float], ...]


def fit(
    learner: Learner,
    data: TrainingData,
    run_dir: Path,
    *,
    seed: int = 0,
    device: str = "auto",
    fingerprint: str = "",
    on_progress: Callable[[Progress], None] | None = None,
) -> FitResult:
    """Train a learner and leave it, on the CPU, with the weights of the best epoch, or of the last (`TrainingConfig.keep`).

    If `run_dir` holds a checkpoint of the same configuration, seed and fingerprint, training resumes from it. A checkpoint
    that was cut off gives way to the previous one. On a CPU the result depends on the seed alone.

    Args:
        learner: Network, losses and configuration.
        data: Training and validation batches.
        run_dir: Folder for `last.ckpt` and `previous.ckpt` (to resume), `best.pt` (kept weights), `metrics.csv` and
            `metrics.json` (one entry an epoch). Made if absent.
        seed: Seed of everything random.
        device: "cpu", "cuda", "cuda:1", "mps", or "auto" for a GPU where there is one.
        fingerprint: Hash of the data, or whatever else a checkpoint must agree with to be resumed.
        on_progress: Called after every epoch, once its files are written.

    Raises:
        InputError: The device does not exist, or the validation error of an epoch is not finite.
    """
    config = learner.training_config
    run_dir.mkdir(parents=True, exist_ok=True)
    identity = json.dumps({"training": asdict(config), "seed": seed, "data": fingerprint}, sort_keys=True)
    run = _Run(learner, seed, pick_device(device))
    run.resume(run_dir, identity)
    with _threads(config.threads), warnings.catch_warnings():
        # a scaler of gradients may skip the very first step, which PyTorch takes for a wrong order of calls
        warnings.filterwarnings("ignore", message=".*lr_scheduler.step.*")
        while (epoch := len(run.history)) < config.epochs:
            training = run.train_epoch(data, epoch)
            metrics = run.validate(data) | training
            error = metrics[MONITOR]
            if not math.isfinite(error):
                raise InputError(run_dir, f"after epoch {epoch + 1} the error is {error}: expected finite training data")
            run.history.append({"epoch": float(epoch), **metrics})
            if error < run.best_error or run.best_epoch < 0 or config.keep == "last":
                run.best_epoch, run.best_error = epoch, error
                _save(run_dir / BEST, {name: tensor.cpu() for name, tensor in run.validated.state_dict().items()})
            run.save(run_dir, identity)
            _write_metrics(run_dir, run.history)
            if on_progress is not None:
                on_progress(Progress(epoch + 1, config.epochs, metrics))
    learner.cpu().load_state_dict(torch.load(run_dir / BEST, map_location="cpu", weights_only=True))
    learner.eval()
    return FitResult(run.best_epoch, run.best_error, tuple(run.history))


class _Run:
    """A training in progress, with everything that a checkpoint restores."""

    def __init__(self, learner: Learner, seed: int, device: str) -> None:
        config, kind = learner.training_config, torch.device(device).type
        self.learner, self.seed, self.device, self.config = learner.to(device), seed, device, config
        self.average = _moving_average(learner, config.average) if config.average else None
        self.validated = learner if self.average is None else cast(Learner, self.average.module)
        self.optimizer = learner.make_optimizer()
        self.schedule = learner.make_schedule(self.optimizer)
        dtype = mixed_dtype(config, kind)
        self.autocast = torch.autocast(kind, dtype, enabled=dtype is not None, cache_enabled=False)
        self.scaler = torch.amp.GradScaler(kind, enabled=dtype is torch.half)
        self.history: list[dict[str, float]] = []
        self.best_epoch, self.best_error = -1, math.inf

    def train_epoch(self, data: TrainingData, epoch: int) -> dict[str, float]:
        """Means of the training metrics over one epoch of steps."""
        learner, optimizer, scaler = self.learner.train(), self.optimizer, self.scaler
        learner.start_epoch(epoch)
        for step, batch in enumerate(data.training_batches(epoch, np.random.default_rng([self.seed, epoch]))):
            torch.manual_seed(int(np.random.default_rng([self.seed, epoch, step]).integers(2**62)))  # of dropout
            with self.autocast:
                loss = learner.training_step(batch.to(self.device))
            optimizer.zero_grad()
            scaler.scale(loss).backward()  # type: ignore[no-untyped-call]
            scaler.unscale_(optimizer)
            if self.config.gradient_clip:
                nn.utils.clip_grad_norm_(learner.parameters(), self.config.gradient_clip)
            scaler.step(optimizer)
            scaler.update()
            if learner.schedule_every_step:
                self.schedule.step()
            if self.average is not None:
                self.average.update_parameters(learner)
        if not learner.schedule_every_step:
            self.schedule.step()
        return {name: float(value) for name, value in learner.take_means().items()}

    @torch.inference_mode()
    def validate(self, data: TrainingData) -> dict[str, float]:
        """Means of the validation metrics, with the averaged weights where there are such."""
        learner = self.validated.eval()
        for batch in data.validation_batches():
            with self.autocast:
                learner.validation_step(batch.to(self.device))
        means = learner.take_means()
        means[MONITOR] = learner.validation_error(means)
        return {name: float(value) for name, value in means.items()}

    def save(self, folder: Path, identity: str) -> None:
        """Write the checkpoint; the one before it stays as the previous one."""
        last, previous = (folder / name for name in CHECKPOINTS)
        if last.exists():
            last.replace(previous)
        states = {name: part.state_dict() for name, part in self._parts().items()}
        _save(last, {"identity": identity, "history": self.history, "best": (self.best_epoch, self.best_error), **states})

    def resume(self, folder: Path, identity: str) -> None:
        """Restore the newest usable checkpoint of this run. Unusable ones are deleted, so that they never displace it."""
        for path in (folder / name for name in CHECKPOINTS):
            try:
                checkpoint = torch.load(path, map_location="cpu", weights_only=True)
                usable = checkpoint.get("identity") == identity
            except Exception:  # a cut file may raise nearly anything: whatever it is, the file cannot be used
                usable = False
            if usable:
                self.history, (self.best_epoch, self.best_error) = checkpoint["history"], checkpoint["best"]
                for name, part in self._parts().items():
                    part.load_state_dict(checkpoint[name])
                return
            path.unlink(missing_ok=True)

    def _parts(self) -> dict[str, Any]:
        parts = {"learner": self.learner, "optimizer": self.optimizer, "schedule": self.schedule, "scaler": self.scaler}
        return parts if self.average is None else {**parts, "average": self.average}


def _moving_average(module: nn.Module, decay: float) -> AveragedModel:
    """Copy of a module (its attribute `module`) whose weights follow the module's by an exponential moving average.

    It is steadier than the last step's weights, and better on unseen shapes. Floating-point buffers, such as the statistics of
    batch norms, are averaged like parameters; other buffers are copied.
    """

    def update(averages: Sequence[Tensor], current: Sequence[Tensor], steps: Tensor | int) -> None:
        if averages[0].is_floating_point():
            share = min(decay, (1.0 + float(steps)) / (WARM_UP_STEPS + float(steps)))
            get_ema_multi_avg_fn(share)(averages, current, steps)  # type: ignore[no-untyped-call]
        else:
            for own, other in zip(averages, current, strict=True):
                own.copy_(other)

    return AveragedModel(module, multi_avg_fn=update, use_buffers=True)


def _save(path: Path, content: dict[str, Any]) -> None:
    buffer = io.BytesIO()
    torch.save(content, buffer)  # torch would not say that the disk is full, if it wrote the file itself
    write_bytes_atomically(path, buffer.getvalue())


def _write_metrics(folder: Path, history: list[dict[str, float]]) -> None:
    table = io.StringIO()
    writer = csv.DictWriter(table, list(dict.fromkeys(name for row in history for name in row)), lineterminator="\n")
    writer.writeheader()
    writer.writerows(history)
    write_text_atomically(folder / METRICS_TABLE, table.getvalue())
    write_json_atomically(folder / METRICS, history)


@contextmanager
def _threads(count: int) -> Iterator[None]:
    """Use so many CPU threads inside the block; 0 leaves their number as it is."""
    before = torch.get_num_threads()
    try:
        torch.set_num_threads(count or before)
        yield
    finally:
        torch.set_num_threads(before)
