"""Procedural shapes for when there is no PartNet yet."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kinmo.core.errors import InputError
from kinmo.core.wording import counted
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.io.folder_lock import locked
from kinmo.io.readers.discover import WORKSPACE
from kinmo.synth.draw import ParameterRange
from kinmo.synth.generate import Layout, generate, orders

SECONDS_PER_SHAPE = 0.05


@dataclass(frozen=True)
class Synth:
    """Write `count` shapes a family and layout (a third of that in DSG-Net's) below `folder`.

    With `held_back` the shapes in PartNet's layout are written with their joints too, into a folder of that name. Empty
    `families` and `layouts` mean all; without a `parameter_range` labelled and unlabelled shapes take their own.
    """

    folder: Path
    count: int
    families: tuple[str, ...] = ()
    layouts: tuple[str, ...] = ()
    parameter_range: ParameterRange | None = None
    held_back: bool = False
    seed: int = 0
    workers: int = 1

    def plan(self) -> Plan:
        total, there = self._counts()
        missing = total - there
        steps = (f"write {missing} procedural shapes below {self.folder}",) if missing else ()
        return Plan(steps, missing * SECONDS_PER_SHAPE / self.workers)

    def run(self, observer: Observer) -> Outcome:
        total, done = self._counts()

        def on_written(path: Path) -> None:
            nonlocal done
            done += 1
            observer.progress("writing shapes", done, total, path.name)

        with locked(self.folder):
            written = generate(self.folder, **self._wish(), workers=self.workers, on_written=on_written)
        data = {"folder": str(self.folder), "shapes": total, "written": written}
        return Outcome(self.folder, data, f"{counted(total, 'shape')}, {written} of them new")

    def _wish(self) -> dict[str, Any]:
        return {
            "count": self.count,
            "families": self.families or None,
            "layouts": tuple(map(Layout, self.layouts)) or tuple(Layout),
            "seed": self.seed,
            "parameter_range": self.parameter_range,
            "held_back": self.held_back,
        }

    def _counts(self) -> tuple[int, int]:
        """How many shapes are wanted, and how many of them are there. Raises InputError where nobody would find them."""
        if (self.folder / WORKSPACE).is_file():
            raise InputError(self.folder, "is a workspace, in which no shapes are looked for: name another folder")
        total = there = 0
        for order in orders(**self._wish()):
            total += 1
            there += (self.folder / order.folder / order.shape_id).exists()
        return total, there
