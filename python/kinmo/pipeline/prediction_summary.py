"""Summary of predictions for people: a line for each joint, and notes about guesses, repairs and exports."""

from __future__ import annotations

import json
from collections.abc import Container, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from kinmo.core.errors import expecting
from kinmo.core.wording import clean_text, printable_path
from kinmo.io.discover import ShapeSource
from kinmo.io.readers.mesh_folder_reader import MESH_FOLDER
from kinmo.io.readers.obj_scene_reader import OBJ
from kinmo.io.readers.overrides_reader import OVERRIDES_FILE
from kinmo.io.readers.ply_reader import PLY
from kinmo.io.readers.stl_reader import STL
from kinmo.io.writers.joints_json_writer import FILE_NAME
from kinmo.pipeline.joint_lines import joint_lines

SUSPICIOUS_SIZE = 20.0
"""Diagonal in metres above which an object is probably in millimetres."""
WITH_ANY_UP = (OBJ, PLY, STL, MESH_FOLDER)
"""Formats whose files have different axes up."""
DOUBTFUL = 0.7
"""Mean score of joints below which a guessed up direction is doubtful."""
MAX_NOTED_SHAPES = 40
"""Most shapes whose repairs and exports are noted. joints.json and --json have all."""
NO_JOINTS = "  no joints found"


def summary_of(found: ShapeSource, folder: Path) -> tuple[dict[str, Any], list[str]]:
    """Short facts about the prediction in a folder, and its lines: the shape, then each joint.

    The facts have the path `urdf` only if the URDF was written.

    Raises InputError if joints.json cannot be read.
    """
    with expecting("joints.json of kinmo predict", folder / FILE_NAME):
        document = json.loads((folder / FILE_NAME).read_text(encoding="utf-8"))
        shape, bodies = document["shape"], document["bodies"]
        joints = joint_lines(document)
        scores = [body["estimates"][0]["score"] for body in bodies if body["joint"] is not None]
        summary: dict[str, Any] = {
            "id": found.id,
            "source": printable_path(found.path),
            "folder": str(folder),
            "category": str(shape["category"]),
            "layout": str(shape["layout"]),
            "parts": sum(len(body["parts"]) for body in bodies),
            "joints": len(joints),
            "mean_score": float(np.mean(scores)) if scores else None,
            **_urdf(document.get("export", {}), folder),
            "diagonal": float(shape["diagonal"]),
            "metres_per_unit": float(shape["metres_per_unit"]),
            "guessed": {str(name): str(line) for name, line in shape["guessed"].items()},
            "repairs": [str(repair) for repair in shape.get("repairs", ())],
            "notes": [str(note) for note in document.get("export", {}).get("notes", ())],
            "corrected": "correction" in document,
        }
    title = f"{_name(summary)} (category {clean_text(summary['category']) or 'unknown'})"
    return summary, [title, *(joints or [NO_JOINTS])]


def _urdf(export: Mapping[str, Any], folder: Path) -> dict[str, str]:
    """The path of the URDF by the name of its format. Empty if the export, as joints.json has it, wrote none."""
    return {"urdf": str(folder / f"{export['name']}.urdf")} if "urdf" in export.get("formats", ()) else {}


def _name(document: Mapping[str, Any]) -> str:
    """Name of a result, which is that of its folder: several shapes may have the same id."""
    return clean_text(Path(document["folder"]).name)


def notes_about(documents: Sequence[dict[str, Any]], uncorrected: Container[Path]) -> Iterator[str]:
    """Lines about predictions that are no joints.

    Args:
        documents: Facts about the predictions (see `summary_of`).
        uncorrected: Folders whose corrections could not be applied.
    """
    for document in [document for document in documents if document["repairs"]][:MAX_NOTED_SHAPES]:
        yield f"repaired: {_name(document)}: {'; '.join(document['repairs'])}"
    for document in [document for document in documents if document["notes"]][:MAX_NOTED_SHAPES]:
        yield f"export of {_name(document)}: {'; '.join(document['notes'])}"
    yield from _guess_lines(documents)
    for document in documents:
        name, folder = _name(document), Path(document["folder"])
        if (size := document["diagonal"] * document["metres_per_unit"]) > SUSPICIOUS_SIZE:
            yield f"{name}: {size:.0f} m across: set --metres-per-unit if the file is not in metres"
        if document["corrected"] and folder not in uncorrected:
            yield f"{name}: corrected by {folder / OVERRIDES_FILE}"
        if document["layout"] == MESH_FOLDER:
            yield f"{name}: its mesh files are the parts of one shape: name files singly if each is a shape"
        is_guess = document["layout"] in WITH_ANY_UP and "up" in document["guessed"]
        if is_guess and document["joints"] and document["mean_score"] < DOUBTFUL:
            yield f"{name}: low scores: is another axis up? (--up z, --up y)"
        if document["parts"] < 2:
            yield f"{name}: has one part, so nothing can move: cut it into one node per moving part"


def _guess_lines(documents: Sequence[dict[str, Any]]) -> list[str]:
    """Lines about guesses: one line for all shapes with the same guesses."""
    names: dict[str, list[str]] = {}
    for document in documents:
        if document["guessed"]:
            options = ", ".join(f"--{name.replace('_', '-')}" for name in document["guessed"])
            names.setdefault(f"{', '.join(document['guessed'].values())} (if wrong: {options})", []).append(_name(document))
    if len(documents) == 1:
        return [f"guessed: {line}" for line in names]
    shapes = {line: same[0] if len(same) == 1 else f"{len(same)} shapes, such as {same[0]}" for line, same in names.items()}
    return [f"guessed for {which}: {line}" for line, which in shapes.items()]
