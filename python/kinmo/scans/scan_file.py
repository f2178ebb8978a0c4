"""Scans on disk: one memory-mapped safetensors file an object, or a variant of one, frames stacked."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, Protocol, get_args

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from kinmo.core.errors import InputError
from kinmo.core.joint import Joint, joint_from_data, joint_to_data
from kinmo.io.atomic_files import write_bytes_atomically
from kinmo.io.file_memo import kept_while_unchanged
from kinmo.scans.articulated_object import Extents, Structure
from kinmo.scans.input_frame import looks
from kinmo.scans.labelled_frames import Scans

F64 = NDArray[np.float64]

FORMAT = 5
_HEADER_KEY = "kinmo"
_ARRAYS = tuple(field.name for field in fields(Scans) if field.name != "refused")

Role = Literal["train", "validation", "test", "hidden", "unlabelled", "pseudo"]
"""What an object is for. Joints of the first four are true, those of `hidden` held back; `unlabelled` ones have none, or what
networks gave them."""
ROLES: tuple[Role, ...] = get_args(Role)


@dataclass(frozen=True)
class Provenance:
    """Where frames come from: `made_from` is a hash of all that they depend on, `layout` that of the object's files.

    A `variant` other than 0 is not the object itself but one like it.
    """

    made_from: str = ""
    role: Role = "train"
    layout: str = ""
    variant: int = 0

    @property
    def has_true_labels(self) -> bool:
        """Whether no network labelled the frames."""
        return self.role not in ("pseudo", "unlabelled")


@dataclass(frozen=True, eq=False)
class ScanFile:
    """The frames of one object; arrays stay on disk until they are asked for.

    `joints` are those of parts 1 and up and `extents` the boxes of the parts, in the normalised frame; `facing` [K] is the
    share of each part's surface that faces an axis, NaN where that is not known.
    """

    path: Path
    id: str
    category: str
    structure: Structure
    joints: tuple[Joint, ...]
    extents: Extents
    facing: F64
    frames: int
    refused: Mapping[str, int]
    provenance: Provenance

    def read(self, name: str, frames: slice | int = slice(None)) -> NDArray[Any]:
        """The array of that name of `Scans`, of all `frames` or of some; or their `looks` (`kinmo.scans.input_frame`), which
        take longer to find than all else that a training needs of a frame.
        """
        try:
            array: NDArray[Any] = self._tensors.get_slice(name)[frames]
            return array
        except (SafetensorError, OSError) as error:
            raise InputError(self.path, f"not whole any more ({error}): run kinmo render again") from None

    @property
    def object(self) -> tuple[str, str]:
        """What tells the object from others of its role; variants of one have the same."""
        return self.id, self.provenance.layout

    @cached_property
    def _tensors(self) -> Any:
        """Opened once: a training reads tens of thousands of frames."""
        return safe_open(self.path, framework="numpy").__enter__()  # type: ignore[no-untyped-call]


def count_objects(files: Iterable[ScanFile]) -> int:
    """How many objects there are scans of, each counted once with its variants."""
    return len({file.object for file in files})


class Described(Protocol):
    """What is known of an object whose frames are written: an `ArticulatedObject`, or what networks think of one.

    `joints` and `part_extents` are in the normalised frame. `facing` is as in `ScanFile`.
    """

    @property
    def id(self) -> str: ...

    @property
    def category(self) -> str: ...

    @property
    def structure(self) -> Structure: ...

    @property
    def joints(self) -> tuple[Joint, ...]: ...

    @property
    def part_extents(self) -> Extents: ...

    @property
    def facing(self) -> F64: ...


def write_scans(path: Path, target: Described, scans: Scans, provenance: Provenance) -> None:
    """Write the frames of `target`, whole or not at all; the same frames give the same bytes."""
    tensors = {name: np.ascontiguousarray(getattr(scans, name)) for name in _ARRAYS}
    tensors["looks"] = looks(scans.points, scans.parts)
    tensors |= {"centers": target.part_extents.centers, "sizes": target.part_extents.sizes, "facing": target.facing}
    header = {
        "format": FORMAT,
        "id": target.id,
        "category": target.category,
        "parents": target.structure.parents,
        "joints": [joint_to_data(joint) for joint in target.joints],
        "frames": len(scans),
        "refused": scans.refused,
        "provenance": asdict(provenance),
    }
    write_bytes_atomically(path, save(tensors, {_HEADER_KEY: json.dumps(header, sort_keys=True)}))


def open_scans(path: Path) -> ScanFile:
    """What `write_scans` wrote, without its frames. Raises InputError for anything else."""
    known = _without_frames(path)
    extents = Extents(known.extents.centers, known.extents.sizes)
    # A new one each time, which keeps the file mapped for as long as it is there itself.
    return replace(known, extents=extents, refused=dict(known.refused))


@kept_while_unchanged
def _without_frames(path: Path) -> ScanFile:
    """The file as it is opened, with arrays that cannot be written to; its frames are not to be read."""
    try:
        with safe_open(path, framework="numpy") as file:
            data = json.loads(file.metadata()[_HEADER_KEY])
            if data["format"] != FORMAT:
                raise ValueError(f"of format {data['format']}, expected {FORMAT}")
            joints = tuple(joint_from_data(joint) for joint in data["joints"])
            centers, sizes, facing = (file.get_tensor(name) for name in ("centers", "sizes", "facing"))
            for array in (centers, sizes, facing, *(each for joint in joints for each in (joint.direction, joint.pivot))):
                array.flags.writeable = False
            return ScanFile(
                path,
                data["id"],
                data["category"],
                Structure(tuple(joint.kind for joint in joints), tuple(data["parents"])),
                joints,
                Extents(centers, sizes),
                facing,
                data["frames"],
                data["refused"],
                Provenance(**data["provenance"]),
            )
    except (SafetensorError, OSError, KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(path, f"not a file of scans ({error}): run kinmo render again") from None


def is_made_from(path: Path, made_from: str) -> bool:
    """Whether `write_scans` wrote the file, with that in its provenance."""
    try:
        return open_scans(path).provenance.made_from == made_from
    except InputError:
        return False
