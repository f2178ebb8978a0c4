"""Generation of procedural shapes: which shapes there are, how one is made, and how many are written in parallel."""

from __future__ import annotations

import shutil
import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path

import numpy as np

from kinmo.core.errors import InputError
from kinmo.dataset.folder_preparation import ORACLE
from kinmo.dataset.jobs import Failure, runner_for
from kinmo.dataset.splits import Split, split_of
from kinmo.io.readers import DSG_NET, PARTNET, PARTNET_MOBILITY
from kinmo.synth.assembly import assemble
from kinmo.synth.draw import Draw, ParameterRange
from kinmo.synth.families import family_builder, family_names
from kinmo.synth.hierarchy_style import apply_hierarchy_style
from kinmo.synth.joint_quirks import add_joint_quirks
from kinmo.synth.mesh_quirks import add_mesh_quirks, flatten_thin_panels
from kinmo.synth.proportions import stretch_object
from kinmo.synth.synth_object import SynthObject
from kinmo.synth.writers import WRITERS

MAX_SHAPES = 100_000
"""Most shapes of one family in one layout."""
SPLIT_CYCLE = tuple(map(Split, ["train", "test", "train", "validation", "train", "train", "test", "train", "train", "train"]))
"""Split of each of ten successive shapes of a family. For a dozen shapes, hashed ids could leave a split empty."""
_ID_LETTERS = {PARTNET_MOBILITY: "m", PARTNET: "p", DSG_NET: "d"}


@dataclass(frozen=True)
class ShapeSpec:
    """One shape to be made. The shape depends on these fields and on nothing else.

    Attributes:
        family: Name of the family.
        index: Number of the shape within its family and layout.
        seed: Seed of the whole run.
        layout: Layout that the shape is made for.
        parameter_range: Window of the family's continuous ranges.
        balances_splits: Choose the id so that it falls into the split that `SPLIT_CYCLE` has for `index`.
        is_oracle: Write the shape with its joints, in PartNet-Mobility's layout, as the oracle copy of an unlabelled shape.
    """

    family: str
    index: int
    seed: int
    layout: str
    parameter_range: ParameterRange
    balances_splits: bool = False
    is_oracle: bool = False

    @property
    def folder(self) -> str:
        """Subfolder that the shape is written to."""
        return ORACLE if self.is_oracle else self.layout

    @property
    def written_layout(self) -> str:
        """Layout that the shape is written in."""
        return PARTNET_MOBILITY if self.is_oracle else self.layout

    @property
    def shape_id(self) -> str:
        """Id of the shape, unique over families, ranges, layouts and seeds. No real object has such an id."""
        stem = f"{self.family}-{self.seed}-{_ID_LETTERS[self.layout]}{self.parameter_range.value[0]}"
        return f"{stem}{_balanced_numbers(stem).at(self.index) if self.balances_splits else self.index:05d}"

    def draw(self, purpose: str) -> Draw:
        """Random values for one purpose ("shape", "finish", "files" and so on), independent of those for others."""
        key = zlib.crc32(f"{self.family}/{self.layout}/{self.parameter_range.value}/{purpose}".encode())
        rng = np.random.default_rng([self.seed, key, self.index])
        return Draw(rng, self.parameter_range if purpose == "shape" else ParameterRange.BOTH)


class _BalancedNumbers:
    """Numbers of ids that fall into the splits of `SPLIT_CYCLE`: the lowest ones for one stem of ids."""

    def __init__(self, stem: str) -> None:
        self._stem, self._tried = stem, 0
        self._found: dict[Split, list[int]] = {split: [] for split in Split}

    def at(self, index: int) -> int:
        """Number of the shape at `index`."""
        rounds, position = divmod(index, len(SPLIT_CYCLE))
        split = SPLIT_CYCLE[position]
        before = rounds * SPLIT_CYCLE.count(split) + SPLIT_CYCLE[:position].count(split)
        while len(self._found[split]) <= before:
            self._found[split_of(f"{self._stem}{self._tried:05d}")].append(self._tried)
            self._tried += 1
        return self._found[split][before]


_balanced_numbers = cache(_BalancedNumbers)


def shape_specs(
    count: int,
    *,
    families: Sequence[str] | None = None,
    layouts: Sequence[str] = tuple(WRITERS),
    seed: int = 0,
    parameter_range: ParameterRange | None = None,
    oracle: bool = False,
) -> Iterator[ShapeSpec]:
    """Specifications of all shapes of a run.

    Args:
        count: Shapes per family and layout. DSG-Net's layout gets a third of that, at least one.
        families: Names of families; None means all.
        layouts: Layouts to write, out of the keys of `WRITERS`.
        seed: Seed of the run.
        parameter_range: Window of all shapes. None gives labelled and unlabelled layouts the windows meant for them. It also
            balances ids, such that every family has shapes for training, validation and test.
        oracle: Repeat every shape in PartNet's layout with its joints.

    Yields:
        One specification per shape.

    Raises:
        InputError: A family or layout is unknown, or the count is out of range.
    """
    if not 1 <= count <= MAX_SHAPES:
        raise InputError("count", f"expected 1 to {MAX_SHAPES}, got {count}")
    chosen = family_names() if families is None else tuple(families)
    for name in chosen:
        family_builder(name)
    for layout in layouts:
        if layout not in WRITERS:
            raise InputError("layout", f"cannot write {layout!r}, expected some of {', '.join(WRITERS)}")
    for layout in layouts:
        labelled = layout == PARTNET_MOBILITY
        usual_range = ParameterRange.LABELLED if labelled else ParameterRange.UNLABELLED
        number = max(1, count // 3) if layout == DSG_NET else count
        for name in chosen:
            for index in range(number):
                balances = parameter_range is None
                spec = ShapeSpec(name, index, seed, layout, parameter_range or usual_range, balances_splits=balances)
                yield spec
                if oracle and layout == PARTNET:
                    yield replace(spec, is_oracle=True)


def build_shape(spec: ShapeSpec) -> SynthObject:
    """Make the object of a specification, with the style and the quirks of real files, ready to be written."""
    obj = family_builder(spec.family)(spec.draw("shape"))
    obj.check()
    stretch_object(obj, spec.draw("proportions"))
    obj.apply_rest_pose()
    finish = spec.draw("finish")
    obj.normalise(finish.between(1.8, 2.25), [finish.between(-0.03, 0.03) for _ in range(3)])
    apply_hierarchy_style(obj, finish)
    assemble(obj, spec.draw("assembly"))
    flatten_thin_panels(obj, finish)
    add_mesh_quirks(obj, finish)
    add_joint_quirks(obj, finish)
    return obj


def write_shapes(
    out: Path, specs: Iterable[ShapeSpec], *, workers: int = 1, on_written: Callable[[Path], None] | None = None
) -> int:
    """Write shapes that are not there yet. Every shape is whole or absent, and the same for any number of workers.

    Args:
        out: Folder; shapes go to its subfolders `ShapeSpec.folder`.
        specs: Shapes to write, such as those of `shape_specs`.
        workers: Number of processes.
        on_written: Called with the folder of each new shape.

    Returns:
        Number of shapes that were written.

    Raises:
        ChildProcessError: A shape could not be written.

    Example:
        >>> write_shapes(Path("partnet"), shape_specs(12, families=["laptop"]))
    """
    missing = (spec for spec in specs if not target_folder(spec, out).exists())
    written = 0
    for spec, path in runner_for(workers).run(partial(write_shape, out=out), missing):
        if isinstance(path, Failure):
            raise ChildProcessError(f"{target_folder(spec, out)}: could not be written: {path.reason}")
        written += 1
        if on_written is not None:
            on_written(path)
    return written


def write_shape(spec: ShapeSpec, out: Path) -> Path:
    """Make one shape and write it as a whole, below `out`. Remains of an interrupted run are removed first.

    Returns:
        Folder of the shape.
    """
    target = target_folder(spec, out)
    unfinished = target.with_name(f".{target.name}.tmp~")
    shutil.rmtree(unfinished, ignore_errors=True)
    unfinished.mkdir(parents=True)
    try:
        WRITERS[spec.written_layout](build_shape(spec), spec.shape_id, unfinished, spec.draw("files"))
        unfinished.rename(target)
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)
    return target


def target_folder(spec: ShapeSpec, out: Path) -> Path:
    """Folder of a shape below `out`."""
    return out / spec.folder / spec.shape_id
