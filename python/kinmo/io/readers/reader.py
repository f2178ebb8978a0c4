"""The interface of a reader: an input format that `discover` recognises and reads."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from pathlib import Path

from kinmo.core.shape import Shape
from kinmo.io.readers.stated_facts import StatedFacts

SourceFiles = tuple[Path, Sequence[Path]]
"""A base folder, and the files and folders of OBJ files that a shape is read from. Those that do not exist are ignored."""


@dataclass(frozen=True)
class Reader:
    """An input format. Each reader module defines one as `READER`.

    Attributes:
        layout: name of the format, as in `Shape.layout`.
        read: reads the shape at a path. Raises InputError, naming file and field, for files that cannot be used.
        source_files: lists the files that the shape at a path is read from.
        id_of_file: gives the id of the shape in a file, or None if the file is not of this format.
        is_shape_folder: tells if a folder is one shape of this format, from its path and the names of its entries.
        endings: endings of file names for formats that users recognise by them, for messages.
        read_stated: reads the shape at a path with facts that the user states. None if these cannot be labels.
        is_bare_mesh: the format has meshes alone, so that such files also belong to datasets of other formats.
        is_robot: the format has joints. Meshes beside and below a file of it belong to it.
    """

    layout: str
    read: Callable[[Path], Shape]
    source_files: Callable[[Path], SourceFiles]
    id_of_file: Callable[[Path], str | None] = lambda path: None
    is_shape_folder: Callable[[Path, AbstractSet[str]], bool] = lambda folder, names: False
    endings: tuple[str, ...] = ()
    read_stated: Callable[[Path, StatedFacts], Shape] | None = None
    is_bare_mesh: bool = False
    is_robot: bool = False
