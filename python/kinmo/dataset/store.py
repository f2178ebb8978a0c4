"""Prepared shapes on disk: one safetensors file a shape, and one index.

The arrays of a `PreparedShape` are the tensors of its file; everything else is JSON under the key `kinmo` of the file's
header. The same shape gives the same bytes.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from kinmo.core.edge_labels import EdgeLabels
from kinmo.core.errors import InputError
from kinmo.core.joint import MotionType, joint_from_data, joint_to_data
from kinmo.core.mobility import Body, Mobility
from kinmo.core.names import name_on_disk
from kinmo.features.prepared_shape import Boxes, PreparedShape
from kinmo.io.file_memo import kept_while_unchanged

FORMAT = 7
"""Of the files; files of another format are made again."""
INDEX = "index.jsonl"
_HEADER_KEY = "kinmo"
_LARGEST_HEADER = 64 << 20
_BOXES = ("minimum_boxes", "symmetric_boxes", "aligned_boxes", "body_boxes")
_ARRAYS = ("up", "center", "leaf_points", "leaf_normals", "leaf_areas", "edges", "edge_distances")
_LABELS = ("types", "bodies", "directions", "pivots")
_PLAIN = (
    "id",
    "category",
    "layout",
    "source",
    "partnet_id",
    "geometry_hash",
    "diagonal",
    "part_ids",
    "part_names",
    "parents",
    "leaves",
)


@dataclass(frozen=True, slots=True)
class IndexEntry:
    """One line of the index. `file` is relative to the store; `source` is what was read, `repairs` what the reader mended.

    The labels of a shape that `is_held_back` are for tests, and to measure what labels are worth: nothing is trained on them.
    """

    id: str
    layout: str
    category: str
    file: str
    source: str
    partnet_id: str | None
    geometry_hash: str
    part_count: int
    leaf_count: int
    joint_count: int
    is_labelled: bool
    repairs: tuple[str, ...] = ()
    is_held_back: bool = False


def file_name(layout: str, shape_id: str) -> str:
    """Path of a shape's file relative to the store."""
    return f"{layout}/{name_on_disk(shape_id)}.safetensors"


def to_bytes(shape: PreparedShape, provenance: Mapping[str, Any]) -> bytes:
    """A file's bytes. `provenance` is plain data on what the shape was made from; `read_header` gives it back."""
    tensors = {name: np.ascontiguousarray(getattr(shape, name)) for name in _ARRAYS}
    for name in _BOXES:
        boxes: Boxes | None = getattr(shape, name)
        if boxes is not None:
            tensors |= {f"{name}.{field.name}": np.ascontiguousarray(getattr(boxes, field.name)) for field in fields(Boxes)}
    if shape.edge_labels is not None:
        tensors |= {f"edge_labels.{name}": np.ascontiguousarray(getattr(shape.edge_labels, name)) for name in _LABELS}
    tensors |= {f"evidence.{name}": np.ascontiguousarray(array) for name, array in shape.evidence.items()}
    header = {name: getattr(shape, name) for name in _PLAIN} | {
        "format": FORMAT,
        "mobility": None if shape.mobility is None else _mobility_to_data(shape.mobility),
        "body_types": {str(body): kind.name for body, kind in shape.body_types.items()},
        "provenance": provenance,
    }
    return save(tensors, {_HEADER_KEY: json.dumps(header, sort_keys=True)})


def read_header(path: Path) -> dict[str, Any]:
    """The JSON of a file's header, without its arrays. Raises InputError if it is not a whole file of this format."""
    try:
        with path.open("rb") as file:
            (length,) = struct.unpack("<Q", file.read(8))
            if length > _LARGEST_HEADER:
                raise ValueError("header too long")
            header = json.loads(file.read(length))
        end = max((entry["data_offsets"][1] for name, entry in header.items() if name != "__metadata__"), default=0)
        data: dict[str, Any] = json.loads(header["__metadata__"][_HEADER_KEY])
        if data["format"] != FORMAT:
            raise ValueError(f"of format {data['format']}, expected {FORMAT}")
        if path.stat().st_size != 8 + length + end:
            raise ValueError("not whole")
    except (OSError, ValueError, KeyError, TypeError, AttributeError, struct.error) as error:
        raise InputError(path, f"not a prepared shape ({error}): run kinmo prepare again") from None
    return data


@kept_while_unchanged
def made_from(path: Path) -> str:
    """A hash of all that a file was prepared from. Raises InputError as `read_header` does."""
    return str(read_header(path)["provenance"]["made_from"])


def read_prepared(path: Path) -> PreparedShape:
    """Reads a prepared shape. Raises InputError if the file is missing, cut, or of another format."""
    header = read_header(path)
    try:
        with safe_open(path, framework="numpy") as file:
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        return _from_parts(header, tensors)
    except (SafetensorError, OSError, KeyError, TypeError, ValueError) as error:
        raise InputError(path, f"not a prepared shape ({error}): run kinmo prepare again") from None


def _from_parts(header: dict[str, Any], tensors: dict[str, NDArray[Any]]) -> PreparedShape:
    arrays: dict[str, Any] = {name: tensors[name] for name in _ARRAYS}
    for name in _BOXES:
        if f"{name}.centers" in tensors:
            arrays[name] = Boxes(**{field.name: tensors[f"{name}.{field.name}"] for field in fields(Boxes)})
    if "edge_labels.types" in tensors:
        arrays["edge_labels"] = EdgeLabels(**{name: tensors[f"edge_labels.{name}"] for name in _LABELS})
    plain: dict[str, Any] = {name: tuple(value) if isinstance(value := header[name], list) else value for name in _PLAIN}
    return PreparedShape(
        **plain,
        **arrays,
        mobility=None if header["mobility"] is None else _mobility_from_data(header["mobility"]),
        body_types={int(body): MotionType[name] for body, name in header["body_types"].items()},
        evidence={name.removeprefix("evidence."): array for name, array in tensors.items() if name.startswith("evidence.")},
    )


def _mobility_to_data(mobility: Mobility) -> dict[str, Any]:
    bodies = [
        {
            "id": body.id,
            "name": body.name,
            "leaves": list(body.leaves),
            "parent": body.parent,
            "joint": None if body.joint is None else joint_to_data(body.joint),
        }
        for body in mobility.bodies
    ]
    return {"bodies": bodies, "junk": sorted(mobility.junk)}


def _mobility_from_data(data: dict[str, Any]) -> Mobility:
    bodies = tuple(
        Body(
            body["id"],
            body["name"],
            tuple(body["leaves"]),
            body["parent"],
            None if body["joint"] is None else joint_from_data(body["joint"]),
        )
        for body in data["bodies"]
    )
    return Mobility(bodies, frozenset(data["junk"]))


class PreparedStore:
    """The prepared shapes that an index lists, in the order of layout and id."""

    def __init__(self, folder: Path) -> None:
        """Reads the index of `folder`. Raises InputError if there is none, or it is not whole."""
        self.folder = Path(folder)
        self.entries: tuple[IndexEntry, ...] = _read_index(self.folder / INDEX)

    def __len__(self) -> int:
        return len(self.entries)

    def __iter__(self) -> Iterator[PreparedShape]:
        """All shapes, one in memory at a time."""
        return map(self.load, self.entries)

    def load(self, entry: IndexEntry) -> PreparedShape:
        """The shape of an entry."""
        return read_prepared(self.folder / entry.file)


def index_text(entries: Sequence[IndexEntry]) -> str:
    """The text of an index, sorted, so that it does not depend on the order in which shapes were done."""
    ordered = sorted(entries, key=lambda entry: (entry.layout, entry.id))
    return "".join(json.dumps(asdict(entry), sort_keys=True) + "\n" for entry in ordered)


@kept_while_unchanged
def _read_index(path: Path) -> tuple[IndexEntry, ...]:
    try:
        with path.open(encoding="utf-8") as lines:
            every = [json.loads(line) for line in lines]
        return tuple(IndexEntry(**{**data, "repairs": tuple(data["repairs"])}) for data in every)
    except FileNotFoundError:
        raise InputError(path, "missing: run kinmo prepare first") from None
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise InputError(path, f"not an index of prepared shapes ({error}): run kinmo prepare again") from None
