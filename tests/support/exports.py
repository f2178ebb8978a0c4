"""Exports of shapes for tests, without physics where only joints and surfaces count."""

from __future__ import annotations

from pathlib import Path

from kinmo.core.mobility import Mobility
from kinmo.core.shape import Shape
from kinmo.core.shape_estimate import ShapeEstimate
from kinmo.io.writers import ExportOptions, write_formats

BARE = ExportOptions(collision="none")


def write_urdf(shape: Shape, result: ShapeEstimate | Mobility, folder: Path, options: ExportOptions = BARE) -> Path:
    """Write a URDF without collision geometry into a folder, and return its path."""
    return _write("urdf", shape, result, folder, options)


def write_partnet_mobility(shape: Shape, result: ShapeEstimate | Mobility, folder: Path, options: ExportOptions = BARE) -> Path:
    """Write a shape in the layout of PartNet-Mobility, and return its folder."""
    return _write("partnet_mobility", shape, result, folder, options)


def write_joints_json(shape: Shape, result: ShapeEstimate | Mobility, folder: Path, options: ExportOptions = BARE) -> Path:
    """Write joints.json into a folder, and return its path."""
    return _write("joints_json", shape, result, folder, options)


def _write(name: str, shape: Shape, result: ShapeEstimate | Mobility, folder: Path, options: ExportOptions) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    return write_formats(shape, result, folder, [name], options)[name]
