"""Stage that writes procedural shapes, for users without PartNet."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.core.wording import counted
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.io.discover import WORKSPACE
from kinmo.io.folder_lock import locked
from kinmo.synth.draw import ParameterRange
from kinmo.synth.generate import ShapeSpec, shape_specs, target_folder, write_shapes
from kinmo.synth.writers import WRITERS

SECONDS_PER_SHAPE = 0.05
"""Rough time to write one shape with one worker."""


@dataclass(frozen=True)
class Synth:
    """Stage that writes procedural shapes and leaves those that exist as they are.

    Attributes:
        folder: Folder to write into.
        count: Shapes per family and layout; a third of that in DSG-Net's layout.
        families: Names of families; empty for all.
        layouts: Names of layouts; empty for all that can be written.
        parameter_range: Window of all shapes; None gives labelled and unlabelled shapes different windows.
        oracle: Write the shapes in PartNet's layout with their joints too, into a subfolder.
        seed: Seed of everything random.
        workers: Number of processes.
    """

    folder: Path
    count: int
    families: tuple[str, ...] = ()
    layouts: tuple[str, ...] = ()
    parameter_range: ParameterRange | None = None
    oracle: bool = False
    seed: int = 0
    workers: int = 1

    def plan(self) -> Plan:
        """Count the shapes that are missing."""
        total, existing = self._counts()
        missing = total - existing
        steps = (f"write {missing} procedural shapes below {self.folder}",) if missing else ()
        return Plan(steps, missing * SECONDS_PER_SHAPE / self.workers)

    def run(self, observer: Observer) -> Outcome:
        """Write the shapes that are missing."""
        total, done = self._counts()

        def on_written(path: Path) -> None:
            nonlocal done
            done += 1
            observer.progress("writing shapes", done, total, path.name)

        with locked(self.folder):
            written = write_shapes(self.folder, self._specs(), workers=self.workers, on_written=on_written)
        data = {"folder": str(self.folder), "shapes": total, "written": written}
        return Outcome(self.folder, data, f"{counted(total, 'shape')}, {written} of them new")

    def _specs(self) -> Iterator[ShapeSpec]:
        return shape_specs(
            self.count,
            families=tuple(dict.fromkeys(self.families)) or None,
            layouts=tuple(dict.fromkeys(self.layouts or WRITERS)),
            seed=self.seed,
            parameter_range=self.parameter_range,
            oracle=self.oracle,
        )

    def _counts(self) -> tuple[int, int]:
        """Number of all shapes, and of those that exist. InputError if the folder is a workspace, where no reader looks."""
        if (self.folder / WORKSPACE).is_file():
            raise InputError(self.folder, "is a workspace, in which no shapes are looked for: name another folder")
        exist = [target_folder(spec, self.folder).exists() for spec in self._specs()]
        return len(exist), sum(exist)
