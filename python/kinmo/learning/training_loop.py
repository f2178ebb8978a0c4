"""One training loop for every network: resumable at any moment, chosen on validation, quiet.

Everything random in an epoch is drawn from (seed, epoch), and a checkpoint is written after every epoch; so a run that was
killed anywhere and started again ends as the run that was not.
"""

from __future__ import annotations

import csv
import io
import json
import logging
import math
import signal
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from itertools import islice
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import torch
from lightning.pytorch import Callback, LightningModule, Trainer
from torch.utils.data import DataLoader, IterableDataset

from kinmo.config import TrainingConfig
from kinmo.core.errors import InputError
from kinmo.io.atomic_files import write_atomically, write_bytes_atomically, write_text_atomically
from kinmo.learning.weight_averaging import ExponentialAverage
from kinmo.learning.weights import pick_device

MONITOR = "validation/error"
"""What a module logs in its validation steps, and what the best epoch is the least of."""

CHECKPOINTS = ("last.ckpt", "previous.ckpt")
BEST = "best.pt"


class TrainingData(Protocol):
    """Batches for `fit`. A batch has a method `to(device)` that returns the same batch there."""

    def training_batches(self, epoch: int, rng: np.random.Generator) -> Sequence[Any] | Iterator[Any]:
        """Batches of one epoch. All randomness must come from `rng`."""

    def validation_batches(self) -> Sequence[Any] | Iterator[Any]:
        """The same batches every time; at least one."""


@dataclass(frozen=True)
class Progress:
    """`epoch` of `epochs` are done; `metrics` are those of the last one."""

    epoch: int
    epochs: int
    metrics: Mapping[str, float]


@dataclass(frozen=True)
class FitResult:
    """`history` has one entry an epoch; `best_epoch`, whose weights the module holds, is an index into it."""

    best_epoch: int
    best_error: float
    history: tuple[Mapping[str, float], ...]


class Learner(LightningModule):
    """A LightningModule that optimises with Adam as a TrainingConfig says. Subclasses define the steps and log `MONITOR`."""

    def __init__(self, training: TrainingConfig) -> None:
        super().__init__()
        self.training_config = training

    def configure_optimizers(self) -> Any:
        config = self.training_config
        optimizer = torch.optim.Adam(self.parameters(), **adam_options(config))
        if config.decay_epochs:
            return [optimizer], [torch.optim.lr_scheduler.StepLR(optimizer, config.decay_epochs, config.decay)]
        return [optimizer], [torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, max(config.epochs, 1))]


def adam_options(config: TrainingConfig) -> dict[str, Any]:
    """How `torch.optim.Adam` and `AdamW` are to step.

    In mixed precision, where Lightning could not clip the gradients of a fused one, as torch thinks best.
    """
    fused = True if config.precision == "32-true" else None
    return {"lr": config.learning_rate, "weight_decay": config.weight_decay, "fused": fused}


def fit(
    module: Learner,
    data: TrainingData,
    run_dir: Path,
    *,
    seed: int = 0,
    device: str = "auto",
    fingerprint: str = "",
    on_progress: Callable[[Progress], None] | None = None,
) -> FitResult:
    """Train `module` and leave it with the weights of the epoch that did best on validation, or of the last (`keep`).

    `run_dir` gets `last.ckpt` and `previous.ckpt` (resume), `best.pt` (weights), `metrics.csv` and `metrics.json` (one entry an
    epoch). If it holds checkpoints of the same configuration, seed and `fingerprint` (say, of the data), training goes on from
    there: with the previous one where the last was cut off, from the start where neither can be read. On a CPU the result
    depends on the seed alone.
    """
    config = module.training_config
    run_dir.mkdir(parents=True, exist_ok=True)
    identity = json.dumps({"training": asdict(config), "seed": seed, "data": fingerprint}, sort_keys=True)
    average = ExponentialAverage(config.average) if config.average else None
    recorder = _Recorder(run_dir, identity, on_progress, config, average)
    device = pick_device(device)
    with _quiet():
        trainer = Trainer(
            accelerator={"cuda": "gpu"}.get(device.split(":")[0], device.split(":")[0]),
            devices=[int(device.split(":")[1])] if ":" in device else config.devices,
            precision=config.precision,
            max_epochs=config.epochs,
            gradient_clip_val=config.gradient_clip or None,
            callbacks=[_Seeding(seed), *([average] if average else []), recorder],
            num_sanity_val_steps=0,
            logger=False,
            enable_checkpointing=False,
            enable_progress_bar=False,
            enable_model_summary=False,
            use_distributed_sampler=False,
            default_root_dir=run_dir,
        )
        resume = _checkpoint_to_resume(run_dir, identity)
        with _interruptible(trainer), _on_threads(config.threads):
            trainer.fit(module, datamodule=None, train_dataloaders=_Loader(data, seed, trainer), ckpt_path=resume,
                        val_dataloaders=_Loader(data, None, trainer), weights_only=True)  # fmt: skip
    module.load_state_dict(torch.load(run_dir / BEST, map_location=module.device, weights_only=True))
    module.eval()
    return FitResult(recorder.best_epoch, recorder.best_error, tuple(recorder.history))


class _Batches(IterableDataset[Any]):
    def __init__(self, batches: Callable[[], Any], rank: int, world: int) -> None:
        self.batches, self.rank, self.world = batches, rank, world

    def __iter__(self) -> Iterator[Any]:
        batches = iter(self.batches())
        while len(turn := tuple(islice(batches, self.world))) == self.world:  # every process gets as many
            yield turn[self.rank]


class _Loader(DataLoader[Any]):
    """Feeds the batches of the trainer's current epoch (or those of validation, without a seed)."""

    def __init__(self, data: TrainingData, seed: int | None, trainer: Trainer) -> None:
        epochs = trainer.max_epochs or 0

        def batches() -> Any:
            if seed is None:
                return data.validation_batches()
            # unlike trainer.current_epoch, right even while a checkpoint is being restored
            epoch = trainer.fit_loop.epoch_progress.current.processed  # type: ignore[attr-defined]
            if epoch >= epochs:
                return ()
            return data.training_batches(epoch, np.random.default_rng([seed, epoch]))

        super().__init__(_Batches(batches, trainer.global_rank, trainer.world_size), batch_size=None)


class _Seeding(Callback):
    """Dropout and the like start every step from (seed, epoch, step)."""

    def __init__(self, seed: int) -> None:
        self.seed = seed

    def on_train_batch_start(self, trainer: Trainer, pl_module: LightningModule, batch: Any, batch_idx: int) -> None:
        torch.manual_seed(int(np.random.default_rng([self.seed, trainer.current_epoch, batch_idx]).integers(2**62)))


class _Recorder(Callback):
    """Keeps metrics, the best weights and the checkpoints."""

    def __init__(
        self,
        folder: Path,
        identity: str,
        on_progress: Callable[[Progress], None] | None,
        config: TrainingConfig,
        average: ExponentialAverage | None,
    ) -> None:
        self.folder, self.identity, self.on_progress = folder, identity, on_progress
        self.config, self.average = config, average
        self.history: list[dict[str, float]] = []
        self.best_epoch, self.best_error = -1, math.inf

    def state_dict(self) -> dict[str, Any]:
        return {"history": self.history, "best_epoch": self.best_epoch, "best_error": self.best_error}

    def load_state_dict(self, state_dict: dict[str, Any]) -> None:
        self.history = list(state_dict["history"])
        self.best_epoch, self.best_error = state_dict["best_epoch"], state_dict["best_error"]

    def on_save_checkpoint(self, trainer: Trainer, pl_module: LightningModule, checkpoint: dict[str, Any]) -> None:
        checkpoint["kinmo_identity"] = self.identity

    def on_train_epoch_end(self, trainer: Trainer, pl_module: LightningModule) -> None:
        metrics = {name: float(trainer.strategy.reduce(value)) for name, value in trainer.callback_metrics.items()}
        epoch = trainer.current_epoch
        self.history = [*self.history[:epoch], {"epoch": float(epoch), **metrics}]
        error = metrics[MONITOR]
        if not math.isfinite(error):
            raise InputError(self.folder, f"after epoch {epoch + 1} the error is {error}: expected finite training data")
        if error < self.best_error or self.best_epoch < 0 or self.config.keep == "last":
            self.best_epoch, self.best_error = epoch, error
            if trainer.is_global_zero:
                validated = self.average.weights() if self.average else pl_module.state_dict()
                weights = {name: tensor.cpu() for name, tensor in validated.items()}
                saved = io.BytesIO()
                torch.save(weights, saved)  # to a file, it would not say that the disk is full
                write_bytes_atomically(self.folder / BEST, saved.getvalue())
        last, previous = (self.folder / name for name in CHECKPOINTS)
        if trainer.is_global_zero and last.exists():
            last.replace(previous)
        if not trainer.is_global_zero:
            trainer.save_checkpoint(last)  # takes part in the gathering, writes nothing
            return
        with write_atomically(last) as scratch:
            trainer.save_checkpoint(scratch)
        self._write_metrics()
        if self.on_progress is not None:
            self.on_progress(Progress(epoch + 1, self.config.epochs, metrics))

    def _write_metrics(self) -> None:
        columns = list(dict.fromkeys(name for row in self.history for name in row))
        table = io.StringIO()
        writer = csv.DictWriter(table, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(self.history)
        write_text_atomically(self.folder / "metrics.csv", table.getvalue())
        write_text_atomically(self.folder / "metrics.json", json.dumps(self.history, indent=1) + "\n")


def _checkpoint_to_resume(folder: Path, identity: str) -> Path | None:
    """The newest usable checkpoint. Newer ones that are not usable go, so that they never displace it."""
    for name in CHECKPOINTS:
        if _usable(path := folder / name, identity):
            return path
        path.unlink(missing_ok=True)
    return None


def _usable(path: Path, identity: str) -> bool:
    """Whether a checkpoint is whole and belongs to this run."""
    if not path.is_file():
        return False
    try:
        checkpoint = torch.load(path, map_location="cpu", weights_only=True, mmap=True)
    except Exception:  # a cut file may raise nearly anything: whatever it is, it cannot be used
        return False
    return bool(checkpoint.get("kinmo_identity") == identity)


@contextmanager
def _on_threads(count: int) -> Iterator[None]:
    """So many threads of the CPU inside the block; 0 leaves them."""
    before = torch.get_num_threads()
    try:
        torch.set_num_threads(count or before)
        yield
    finally:
        torch.set_num_threads(before)


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep Lightning's banners and hints off the terminal: `on_progress` is what users see."""
    loggers = [logging.getLogger(name) for name in ("lightning.pytorch", "lightning.fabric", "lightning")]
    levels = [logger.level for logger in loggers]
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", module="lightning")
        warnings.filterwarnings("ignore", message=".*lr_scheduler.step.*")
        for logger in loggers:
            logger.setLevel(logging.ERROR)
        try:
            yield
        finally:
            for logger, level in zip(loggers, levels, strict=True):
                logger.setLevel(level)


@contextmanager
def _interruptible(trainer: Trainer) -> Iterator[None]:
    """Lightning turns Ctrl-C into an exit with the signal ignored; turn it back into a KeyboardInterrupt."""
    try:
        handler = signal.getsignal(signal.SIGINT)
        yield
    except SystemExit as error:
        if trainer.interrupted:
            signal.signal(signal.SIGINT, handler)
            raise KeyboardInterrupt from error
        raise
