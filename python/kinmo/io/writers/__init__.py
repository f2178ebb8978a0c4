"""Writers of shapes with joints, one output format per module.

To add a format, write a module `<format>_writer.py` with a function of the form `kinmo.io.writers.writer.Writer`, and list it
in `WRITERS`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from kinmo.core.errors import InputError, did_you_mean
from kinmo.core.mobility import Mobility
from kinmo.core.shape import Shape
from kinmo.core.shape_estimate import ShapeEstimate
from kinmo.io.atomic_files import write_folder_atomically
from kinmo.io.writers.glb_writer import write_glb
from kinmo.io.writers.joints_json_writer import write_joints_json
from kinmo.io.writers.mjcf_writer import write_mjcf
from kinmo.io.writers.partnet_mobility_writer import write_partnet_mobility
from kinmo.io.writers.urdf_writer import write_urdf
from kinmo.io.writers.writer import ExportedObject, ExportOptions, Writer

__all__ = ["WRITERS", "ExportOptions", "ExportedObject", "Writer", "check_formats", "export", "write_formats"]

WRITERS: dict[str, Writer] = {
    "glb": write_glb,
    "joints_json": write_joints_json,
    "mjcf": write_mjcf,
    "partnet_mobility": write_partnet_mobility,
    "urdf": write_urdf,
}
"""All writers by the name of their format."""


def export(
    shape: Shape,
    result: ShapeEstimate | Mobility,
    folder: Path,
    formats: Sequence[str],
    options: ExportOptions = ExportOptions(),  # noqa: B008 (frozen)
) -> dict[str, Path]:
    """Write a shape with its joints in some formats, keys of `WRITERS`, into one folder.

    The folder is replaced as a whole. If the export fails, it is unchanged. Returns the path of the main file of each format.
    """
    check_formats(formats)
    with write_folder_atomically(folder) as draft:
        written = write_formats(shape, result, draft, formats, options)
    return {name: folder / path.relative_to(draft) for name, path in written.items()}


def check_formats(formats: Sequence[str]) -> None:
    """Raise InputError if one of the names is no key of `WRITERS`."""
    for name in formats:
        if name not in WRITERS:
            known = ", ".join(WRITERS)
            raise InputError("formats", f"unknown format {name}{did_you_mean(name, WRITERS)}; expected one of {known}")


def write_formats(
    shape: Shape,
    result: ShapeEstimate | Mobility,
    folder: Path,
    formats: Sequence[str],
    options: ExportOptions,
    notes: list[str] | None = None,
) -> dict[str, Path]:
    """Write some formats into a folder that exists.

    Args:
        shape: The shape.
        result: Its joints.
        folder: The folder.
        formats: Keys of `WRITERS`.
        options: Settings.
        notes: Receives a line for everything that a format cannot carry. joints.json has them too.

    Returns:
        Path of the main file of each format.
    """
    exported = ExportedObject(shape, result, replace(options, formats=tuple(formats)), [] if notes is None else notes)
    last = sorted(formats, key=lambda name: WRITERS[name] is write_joints_json)  # it has the notes of the others
    written = {name: WRITERS[name](exported, folder) for name in last}
    return {name: written[name] for name in formats}
