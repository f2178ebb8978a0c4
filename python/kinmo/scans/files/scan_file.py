"""Labelled frames on disk: one memory-mapped safetensors file per object or variant."""

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
from kinmo.scans.object_structure import Extents, Structure
from kinmo.scans.preprocessing.input_frame import two_pass_axes
from kinmo.scans.rendering.labelled_frames import LabelledFrames

F64 = NDArray[np.float64]

FORMAT = 6
"""Version of the file format."""
_HEADER_KEY = "kinmo"
_ARRAYS = tuple(field.name for field in fields(LabelledFrames) if field.name != "skipped")

Role = Literal["train", "validation", "test", "oracle", "unlabelled", "pseudo"]
"""Use of an object. The first four have true joints; those of `oracle` objects are hidden from all other training. `pseudo`
objects have pseudo labels. `unlabelled` objects have no joints, or those that networks predicted."""
ROLES: tuple[Role, ...] = get_args(Role)


@dataclass(frozen=True)
class ScanProvenance:
    """Origin of the frames in a file.

    Attributes:
        key: Cache key: a hash of everything that the frames depend on.
        layout: Layout of the object's files.
        variant: 0 for the object itself, else the number of its variant (`object_variants`).
    """

    key: str = ""
    role: Role = "train"
    layout: str = ""
    variant: int = 0

    @property
    def has_true_labels(self) -> bool:
        """False if a network labelled the frames."""
        return self.role not in ("pseudo", "unlabelled")


@dataclass(frozen=True, eq=False)
class ScanFile:
    """The frames of one object; arrays stay on disk until they are read.

    Attributes:
        joints: Joints of parts 1 and up, in the normalised frame.
        extents: Boxes of the K parts in the canonical pose, in the normalised frame.
        axis_aligned_shares: Share [K] of each part's surface that is axis-aligned; NaN if unknown.
        frames: Number of frames.
        skipped: Number of skipped frames by reason.
    """

    path: Path
    id: str
    category: str
    structure: Structure
    joints: tuple[Joint, ...]
    extents: Extents
    axis_aligned_shares: F64
    frames: int
    skipped: Mapping[str, int]
    provenance: ScanProvenance

    def read(self, name: str, frames: slice | int = slice(None)) -> NDArray[Any]:
        """Read an array of some frames, which are along its first axis; InputError if the file is damaged.

        Arrays are those of `LabelledFrames`, and `input_axes` [F, 2, 3, 3] (`two_pass_axes`). These are stored because their
        computation takes longer than everything else that training needs of a frame.
        """
        try:
            array: NDArray[Any] = self._tensors.get_slice(name)[frames]
            return array
        except (SafetensorError, OSError) as error:
            raise InputError(self.path, f"not whole any more ({error}): run kinmo render again") from None

    @property
    def object(self) -> tuple[str, str]:
        """Key of the object among those of its role; variants share it."""
        return self.id, self.provenance.layout

    @cached_property
    def _tensors(self) -> Any:
        """The file, opened once because training reads tens of thousands of frames."""
        return safe_open(self.path, framework="numpy").__enter__()  # type: ignore[no-untyped-call]


def count_objects(files: Iterable[ScanFile]) -> int:
    """Number of objects in some files, each counted once with its variants."""
    return len({file.object for file in files})


class ScannedObject(Protocol):
    """Object whose frames are written: an `ArticulatedObject`, or a network's estimate of one.

    `joints` and `part_extents` are in the normalised frame; `axis_aligned_shares` is as in `ScanFile`.
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
    def axis_aligned_shares(self) -> F64: ...


def write_scans(path: Path, target: ScannedObject, scans: LabelledFrames, provenance: ScanProvenance) -> None:
    """Write an object's frames atomically; equal frames give equal bytes."""
    tensors = {name: np.ascontiguousarray(getattr(scans, name)) for name in _ARRAYS}
    tensors["input_axes"] = two_pass_axes(scans.points, scans.parts)
    tensors |= {"centers": target.part_extents.centers, "sizes": target.part_extents.sizes}
    tensors["axis_aligned_shares"] = target.axis_aligned_shares
    header = {
        "format": FORMAT,
        "id": target.id,
        "category": target.category,
        "parents": target.structure.parents,
        "joints": [joint_to_data(joint) for joint in target.joints],
        "frames": len(scans),
        "skipped": scans.skipped,
        "provenance": asdict(provenance),
    }
    write_bytes_atomically(path, save(tensors, {_HEADER_KEY: json.dumps(header, sort_keys=True)}))


def open_scans(path: Path) -> ScanFile:
    """Open a file that `write_scans` wrote, without reading its frames; InputError for any other file."""
    known = _opened(path)
    # A new object each time: it keeps the file mapped, but no longer than it lives.
    return replace(known, extents=Extents(known.extents.centers, known.extents.sizes), skipped=dict(known.skipped))


@kept_while_unchanged
def _opened(path: Path) -> ScanFile:
    """The file with read-only arrays; its frames must not be read."""
    try:
        with safe_open(path, framework="numpy") as file:
            data = json.loads(file.metadata()[_HEADER_KEY])
            if data["format"] != FORMAT:
                raise ValueError(f"of format {data['format']}, expected {FORMAT}")
            joints = tuple(joint_from_data(joint) for joint in data["joints"])
            centers, sizes, shares = (file.get_tensor(name) for name in ("centers", "sizes", "axis_aligned_shares"))
            for array in (centers, sizes, shares, *(each for joint in joints for each in (joint.direction, joint.pivot))):
                array.flags.writeable = False
            return ScanFile(
                path,
                data["id"],
                data["category"],
                Structure(tuple(joint.kind for joint in joints), tuple(data["parents"])),
                joints,
                Extents(centers, sizes),
                shares,
                data["frames"],
                data["skipped"],
                ScanProvenance(**data["provenance"]),
            )
    except (SafetensorError, OSError, KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(path, f"not a file of scans ({error}): run kinmo render again") from None
