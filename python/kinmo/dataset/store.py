"""Prepared shapes on disk: one safetensors file per shape, and one index.

The arrays of a `PreparedShape` are the tensors of its file. Everything else is JSON under the key `kinmo` of the file's header.
The same shape gives the same bytes.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from kinmo.core.edge_labels import EdgeLabels
from kinmo.core.errors import InputError
from kinmo.core.joint import joint_from_data, joint_to_data
from kinmo.core.mobility import Body, Mobility
from kinmo.core.motion_types import MotionType
from kinmo.core.names import name_on_disk
from kinmo.dataset.workspace import Selection
from kinmo.features.prepared_shape import Boxes, PreparedShape
from kinmo.io.atomic_files import write_text_atomically
from kinmo.io.file_memo import kept_while_unchanged

FORMAT = 10
"""Version of the file format; files of another version are made again."""
INDEX = "index.jsonl"
"""File that lists the shapes of the dataset, one JSON object per line."""
_HEADER_KEY = "kinmo"
_ARRAYS = ("up", "center", "leaf_points", "leaf_normals", "leaf_areas", "edges", "edge_distances")
_GROUPS: dict[str, Callable[..., Any]] = {
    "minimum_boxes": Boxes,
    "symmetric_boxes": Boxes,
    "aligned_boxes": Boxes,
    "body_boxes": Boxes,
    "edge_labels": EdgeLabels,
    "candidate_features": dict,
    "contact_graph": dict,
}
"""Fields that hold several arrays, with their types. The tensor `edge_labels.types` is the array `types` of `edge_labels`."""
_PLAIN = (
    "id", "category", "layout", "source", "partnet_id", "geometry_hash", "diagonal",
    "part_ids", "part_names", "parents", "leaves",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class IndexEntry:
    """One shape of the dataset.

    Attributes:
        id: id of the shape, unique within its layout.
        layout: input format, a key of `kinmo.io.readers.READERS`.
        file: path of the prepared shape, relative to the store (or absolute).
        key: cache key of the prepared shape: it changes with the source files and with the preparation.
        partnet_id: PartNet annotation that the shape comes from; None if unknown.
        geometry_hash: hash of the surface, equal for copies.
        joint_count: number of annotated joints.
        is_labelled: the shape has an annotation of its joints, maybe with none.
        repairs: what the reader repaired.
        is_oracle: its labels are oracle labels. Nothing is trained on them; they test, and measure what labels are worth.
    """

    id: str
    layout: str
    category: str
    file: str
    source: str
    key: str
    partnet_id: str | None
    geometry_hash: str
    part_count: int
    leaf_count: int
    joint_count: int
    is_labelled: bool
    repairs: tuple[str, ...] = ()
    is_oracle: bool = False


def entry_from_data(data: Mapping[str, Any]) -> IndexEntry:
    """The entry that `dataclasses.asdict` took apart. Raises TypeError or KeyError for anything else."""
    return IndexEntry(**{**data, "repairs": tuple(data["repairs"])})


def file_name(layout: str, shape_id: str) -> str:
    """Path of a prepared shape, relative to the store."""
    return f"{layout}/{name_on_disk(shape_id)}.safetensors"


def to_bytes(shape: PreparedShape) -> bytes:
    """Contents of the file of a prepared shape."""
    tensors = {name: getattr(shape, name) for name in _ARRAYS}
    for name in _GROUPS:
        group = getattr(shape, name)
        if group is not None:
            members = group if isinstance(group, Mapping) else vars(group)
            tensors |= {f"{name}.{member}": array for member, array in members.items()}
    mobility = None
    if shape.mobility is not None:
        mobility = {"bodies": list(map(_body_to_data, shape.mobility.bodies)), "junk": sorted(shape.mobility.junk)}
    header = {name: getattr(shape, name) for name in _PLAIN} | {
        "format": FORMAT,
        "mobility": mobility,
        "body_types": {str(body): kind.name for body, kind in shape.body_types.items()},
    }
    arrays = {name: np.ascontiguousarray(array) for name, array in tensors.items()}
    return save(arrays, {_HEADER_KEY: json.dumps(header, sort_keys=True)})


def read_prepared(path: Path) -> PreparedShape:
    """Read a prepared shape. Raises InputError if the file is missing, damaged, or of another format."""
    try:
        with safe_open(path, framework="numpy") as file:
            header = json.loads(file.metadata()[_HEADER_KEY])
            if header["format"] != FORMAT:
                raise ValueError(f"format {header['format']}, expected {FORMAT}")
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        return _from_parts(header, tensors)
    except (SafetensorError, OSError, KeyError, TypeError, ValueError) as error:
        raise InputError(path, f"not a prepared shape ({error}): run kinmo prepare again") from None


def _from_parts(header: dict[str, Any], tensors: dict[str, NDArray[Any]]) -> PreparedShape:
    members: dict[str, dict[str, NDArray[Any]]] = {}
    for name, array in tensors.items():
        group, _, member = name.partition(".")
        members.setdefault(group, {})[member] = array
    arrays: dict[str, Any] = {name: tensors[name] for name in _ARRAYS}
    groups: dict[str, Any] = {name: kind(**members[name]) for name, kind in _GROUPS.items() if name in members}
    plain: dict[str, Any] = {name: tuple(value) if isinstance(value := header[name], list) else value for name in _PLAIN}
    mobility = None
    if (data := header["mobility"]) is not None:
        mobility = Mobility(tuple(map(_body_from_data, data["bodies"])), frozenset(data["junk"]))
    return PreparedShape(
        **plain,
        **arrays,
        **groups,
        mobility=mobility,
        body_types={int(body): MotionType[name] for body, name in header["body_types"].items()},
    )


def _body_to_data(body: Body) -> dict[str, Any]:
    return {**vars(body), "joint": None if body.joint is None else joint_to_data(body.joint)}


def _body_from_data(data: dict[str, Any]) -> Body:
    joint = None if data["joint"] is None else joint_from_data(data["joint"])
    return Body(**{**data, "leaves": tuple(data["leaves"]), "joint": joint})


class PreparedStore:
    """The prepared shapes that the index of a folder lists, in the order of layout and id.

    `select` gives the entries to use (`Workspace.select`). Raises InputError if there is no index, or it cannot be read.
    """

    def __init__(self, folder: Path, select: Selection | None = None) -> None:
        self.folder = Path(folder)
        entries = _read_index(self.folder / INDEX)
        self.entries: tuple[IndexEntry, ...] = entries if select is None else tuple(select(entries))

    def __len__(self) -> int:
        return len(self.entries)

    def load(self, entry: IndexEntry) -> PreparedShape:
        """The shape of an entry."""
        return read_prepared(self.folder / entry.file)


def write_index(folder: Path, entries: Iterable[IndexEntry]) -> None:
    """Write the index of a store, sorted, so that it does not depend on the order in which shapes were prepared."""
    ordered = sorted(entries, key=lambda entry: (entry.layout, entry.id))
    write_text_atomically(folder / INDEX, "".join(json.dumps(asdict(entry), sort_keys=True) + "\n" for entry in ordered))


@kept_while_unchanged
def _read_index(path: Path) -> tuple[IndexEntry, ...]:
    try:
        with path.open(encoding="utf-8") as lines:
            return tuple(entry_from_data(json.loads(line)) for line in lines)
    except FileNotFoundError:
        raise InputError(path, "missing: run kinmo prepare first") from None
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise InputError(path, f"not an index of prepared shapes ({error}): run kinmo prepare again") from None
