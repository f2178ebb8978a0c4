"""Things that a person may look at: results of kinmo predict, robot files, and other 3D files."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from kinmo.api.load import load
from kinmo.api.prediction import Prediction
from kinmo.core.errors import InputError
from kinmo.core.shape import Shape
from kinmo.core.wording import clean_text
from kinmo.dataset.stage import Observer
from kinmo.io.readers.overrides_reader import OVERRIDES_FILE
from kinmo.io.writers.joints_json_writer import FILE_NAME
from kinmo.pipeline.export_results import find_results
from kinmo.view.corrections import Corrections
from kinmo.view.object_scene import ObjectScene
from kinmo.view.scene_building import scene_of

MAX_LISTED = 5
"""Largest number of results that a message lists."""


@dataclass(frozen=True, eq=False)
class OpenedItem:
    """A prediction or a shape.

    Attributes:
        item: the prediction, or the shape with its own joints.
        folder: the folder with joints.json. None for other files.
        name: what tells it from the other items. Empty for the id of the shape, which several results may have.
    """

    item: Prediction | Shape
    folder: Path | None = None
    name: str = ""

    def note_repairs(self, observer: Observer) -> None:
        """Show what the reader of the shape had to repair, in one line."""
        shape = self.item if isinstance(self.item, Shape) else self.item.shape
        if shape.repairs:
            observer.note(f"repaired: {clean_text(shape.id)}: {'; '.join(shape.repairs)}")

    def scene(self) -> ObjectScene:
        """The scene, with the corrections of an overrides.toml in the folder."""
        item = self.item if isinstance(self.item, Shape) else Corrections.of(self.item, self.folder).prediction
        scene = scene_of(item)
        return replace(scene, name=self.name) if self.name else scene


def open_items(path: Path, source: Path | None = None) -> list[OpenedItem]:
    """Read all results at or below a folder, or one file.

    Args:
        path: A result of kinmo predict, a folder with results, or any file or folder that kinmo reads as a shape.
        source: The file of the shape, if it is no longer where joints.json says. For one result alone.

    Returns:
        At least one item.

    Raises:
        InputError: Nothing is there, or it cannot be read.
    """
    if path.name in (FILE_NAME, OVERRIDES_FILE):
        path = path.parent
    folders = list(find_results(path)) if path.is_dir() else []
    if source is not None and len(folders) != 1:
        raise InputError("--source", f"applies only to one result of kinmo predict; found {len(folders)} at {path}")
    if folders:
        return [OpenedItem(Prediction.load(folder, source=source), folder, _name(folder, path)) for folder in folders]
    return [OpenedItem(load(path))]


def open_one(path: Path, source: Path | None = None) -> OpenedItem:
    """Read one result or file (see `open_items`).

    Raises:
        InputError: There are several results, or the one cannot be read.
    """
    folders = list(find_results(path)) if path.is_dir() else []
    if len(folders) > 1:
        names = ", ".join(str(folder) for folder in folders[:MAX_LISTED])
        raise InputError(path, f"has {len(folders)} results: name one of them, such as {names}")
    return open_items(path, source)[0]


def _name(folder: Path, root: Path) -> str:
    """The path of a result below the folder that was opened, or the name of that folder."""
    return clean_text(folder.resolve().name if folder == root else str(folder.relative_to(root)))
