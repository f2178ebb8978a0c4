"""Writing procedural shapes to a folder, any number of them, on any number of processes."""

from __future__ import annotations

import shutil
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cache, partial
from pathlib import Path
from types import ModuleType

import numpy as np

from kinmo.core.errors import InputError
from kinmo.dataset.folder_preparation import HELD_BACK
from kinmo.dataset.splits import Split, split_of
from kinmo.dataset.workers import Crashed, map_unordered
from kinmo.synth.draw import Draw, ParameterRange
from kinmo.synth.families import family, family_names
from kinmo.synth.hierarchy_style import arrange
from kinmo.synth.joint_quirks import misstate
from kinmo.synth.mesh_quirks import flatten, roughen
from kinmo.synth.model import SynthObject
from kinmo.synth.writers import dsg_net, partnet, partnet_mobility

MOST_SHAPES = 100_000
"""Of a family and layout."""
SPLITS = tuple(map(Split, ["train", "test", "train", "validation", "train", "train", "test", "train", "train", "train"]))
"""What every ten shapes of a family are for, where ids are chosen by that: a dozen are too few to leave it to their hashes."""


class Layout(str, Enum):
    """The layouts that can be written; each goes to a subfolder of this name."""

    PARTNET_MOBILITY = "partnet_mobility"
    PARTNET = "partnet"
    DSG_NET = "dsg_net"

    @property
    def letter(self) -> str:
        return {"partnet_mobility": "m", "partnet": "p", "dsg_net": "d"}[self.value]

    @property
    def writer(self) -> ModuleType:
        return {"partnet_mobility": partnet_mobility, "partnet": partnet, "dsg_net": dsg_net}[self.value]


@dataclass(frozen=True)
class Order:
    """One shape to be made. The shape depends on these fields and on nothing else.

    With `chooses_split` its id, which decides what it is for, is chosen so that `SPLITS` says that too.
    One that `shows_joints` is written with them, in PartNet-Mobility's layout, whatever layout it has without.
    """

    family: str
    index: int
    seed: int
    layout: Layout
    parameter_range: ParameterRange
    chooses_split: bool = False
    shows_joints: bool = False

    @property
    def folder(self) -> str:
        """The subfolder that it is written to."""
        return HELD_BACK if self.shows_joints else self.layout.value

    @property
    def writer(self) -> ModuleType:
        return partnet_mobility if self.shows_joints else self.layout.writer

    @property
    def shape_id(self) -> str:
        """Unique over families, ranges, layouts and seeds, and no id that a real object has."""
        stem = f"{self.family}-{self.seed}-{self.layout.letter}{self.parameter_range.value[0]}"
        return f"{stem}{_numbers(stem).of(self.index) if self.chooses_split else self.index:05d}"

    def draw(self, purpose: str) -> Draw:
        """Random values for one purpose, independent of those for others."""
        key = zlib.crc32(f"{self.family}/{self.layout.value}/{self.parameter_range.value}/{purpose}".encode())
        rng = np.random.default_rng([self.seed, key, self.index])
        return Draw(rng, self.parameter_range if purpose == "shape" else ParameterRange.BOTH)


class _Numbers:
    """The lowest numbers with which ids are in the splits of `SPLITS`."""

    def __init__(self, stem: str) -> None:
        self._stem, self._tried = stem, 0
        self._found: dict[Split, list[int]] = {split: [] for split in Split}

    def of(self, index: int) -> int:
        """That of the shape at `index`."""
        rounds, place = divmod(index, len(SPLITS))
        split = SPLITS[place]
        before = rounds * SPLITS.count(split) + SPLITS[:place].count(split)
        while len(self._found[split]) <= before:
            self._found[split_of(f"{self._stem}{self._tried:05d}")].append(self._tried)
            self._tried += 1
        return self._found[split][before]


_numbers = cache(_Numbers)


def build(order: Order) -> SynthObject:
    """The object of an order, with the style and the quirks of real files, ready to be written."""
    obj = family(order.family)(order.draw("shape"))
    obj.check()
    obj.settle()
    finish = order.draw("finish")
    obj.normalise(finish.between(1.8, 2.25), [finish.between(-0.03, 0.03) for _ in range(3)])
    arrange(obj, finish)
    flatten(obj, finish)
    roughen(obj, finish)
    misstate(obj, finish)
    return obj


def orders(
    count: int,
    *,
    families: Sequence[str] | None = None,
    layouts: Sequence[Layout] = tuple(Layout),
    seed: int = 0,
    parameter_range: ParameterRange | None = None,
    held_back: bool = False,
) -> Iterator[Order]:
    """`count` shapes a family and layout; a third of that, at least one, in DSG-Net's layout.

    Without a `parameter_range`, labelled and unlabelled layouts take the range that is meant for them, and ids are such that of
    every family there are shapes to train on, to choose by and to test (`SPLITS`). With `held_back` every shape in PartNet's
    layout comes once more, with its joints. Raises InputError for an unknown family or a count out of range.
    """
    if not 1 <= count <= MOST_SHAPES:
        raise InputError("count", f"expected 1 to {MOST_SHAPES}, got {count}")
    chosen = family_names() if families is None else tuple(families)
    for name in chosen:
        family(name)
    for layout in layouts:
        labelled = layout is Layout.PARTNET_MOBILITY
        fitting = ParameterRange.LABELLED if labelled else ParameterRange.UNLABELLED
        number = max(1, count // 3) if layout is Layout.DSG_NET else count
        for name in chosen:
            for index in range(number):
                order = Order(name, index, seed, layout, parameter_range or fitting, chooses_split=parameter_range is None)
                yield order
                if held_back and layout is Layout.PARTNET:
                    yield replace(order, shows_joints=True)


def generate(
    out: Path,
    *,
    count: int,
    families: Sequence[str] | None = None,
    layouts: Sequence[Layout] = tuple(Layout),
    seed: int = 0,
    parameter_range: ParameterRange | None = None,
    held_back: bool = False,
    workers: int = 1,
    on_written: Callable[[Path], None] | None = None,
) -> int:
    """Write shapes below `out`/<layout>/ and return how many were written; those that are there already are left as they are.

    Every shape is whole or absent, and the same whatever `workers` is. `on_written` hears of each new one.
    Raises InputError for an unknown family or a count out of range.
    """
    todo = orders(count, families=families, layouts=layouts, seed=seed, parameter_range=parameter_range, held_back=held_back)
    jobs = (order for order in todo if not _target(order, out).exists())
    written = 0
    for order, path in map_unordered(partial(write, out=out), jobs, workers):
        if isinstance(path, Crashed):
            raise ChildProcessError(f"{_target(order, out)}: the process that wrote it died")
        written += 1
        if on_written is not None:
            on_written(path)
    return written


def write(order: Order, out: Path) -> Path:
    """Make one shape and put it in place as a whole. What a killed process left of it is cleared away."""
    target = _target(order, out)
    unfinished = target.with_name(f".{target.name}.tmp~")
    shutil.rmtree(unfinished, ignore_errors=True)
    unfinished.mkdir(parents=True)
    try:
        order.writer.write(build(order), order.shape_id, unfinished, order.draw("files"))
        unfinished.rename(target)
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)
    return target


def _target(order: Order, out: Path) -> Path:
    return out / order.folder / order.shape_id
