"""Articulated objects of scene_synthesizer, as URDF folders: objects that kinmo's authors did not model.

scene_synthesizer (NVIDIA, Apache-2.0) builds kitchen furniture, appliances and switches from parameters. This script draws the
parameters of every articulated asset at random. It writes the objects closed, with one mesh for each board, panel and handle,
and with the generator's own names. Objects are z-up, in metres. kinmo is not needed.

Left out: HandWheelAsset, which has no base to turn against.

Usage:
    python bench/collect_scene_synthesizer.py --out DIR [--count 15] [--seed 0] [--assets NAME ...]
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from importlib import metadata
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from urdf_objects import Connection, Piece, UrdfObject, collector_parser, write_urdf_object

Arguments = dict[str, Any]
Draw = Callable[[np.random.Generator, str], Arguments]
"""Draws the arguments of an asset's constructor. The text is a folder for the generator's intermediate meshes."""


@dataclass(frozen=True)
class Asset:
    """An asset: the name of its class in the generator, the category of its objects, its arguments, and its front."""

    class_name: str
    category: str
    draw: Draw
    front: str = "-y"


def handle_shape(rng: np.random.Generator, folder: str) -> Arguments:
    """Shape of a curved handle."""
    return {
        "straight_ratio": rng.uniform(0.3, 1.0),
        "curvature_ratio": rng.uniform(0.0, 1.0),
        "num_segments_cross_section": int(rng.integers(6, 13)),
        "num_segments_curvature": int(rng.integers(4, 13)),
        "aspect_ratio_cross_section": rng.uniform(0.3, 1.2),
        "tmp_mesh_dir": folder,
    }


def panel_shape(rng: np.random.Generator, folder: str) -> Arguments | None:
    """Shape of a door with mouldings. None for a plain board."""
    if rng.random() < 0.5:
        return None
    return {
        "inner_depth_ratio": rng.uniform(0.2, 1.0),
        "outer_depth_ratio": rng.uniform(0.5, 1.0),
        "trim_depth_ratio": rng.uniform(0.0, 1.0),
        "trim_width_ratio": rng.uniform(0.2, 0.8),
        "num_depth_sections": int(rng.integers(10, 20)),
        "tmp_mesh_dir": folder,
    }


def cabinet_fittings(rng: np.random.Generator, folder: str) -> Arguments:
    """Handles, doors and walls of a cabinet."""
    return {
        "handle_width": rng.uniform(0.08, 0.25),
        "handle_height": rng.uniform(0.025, 0.05),
        "handle_depth": rng.uniform(0.012, 0.03),
        "handle_shape_args": handle_shape(rng, folder) if rng.random() < 0.5 else None,
        "door_shape_args": panel_shape(rng, folder),
    }


def size(
    rng: np.random.Generator, width: tuple[float, float], depth: tuple[float, float], height: tuple[float, float]
) -> Arguments:
    """Width, depth and height between bounds, in metres."""
    return {"width": rng.uniform(*width), "depth": rng.uniform(*depth), "height": rng.uniform(*height)}


def refrigerator(rng: np.random.Generator, folder: str) -> Arguments:
    """A refrigerator with a freezer above. Without a freezer the generator makes a door of negative height."""
    box = size(rng, (0.5, 0.95), (0.55, 0.85), (1.1, 2.0))
    return box | {
        "freezer_compartment_height": rng.uniform(0.2, 0.5) * box["height"],
        "thickness": rng.uniform(0.04, 0.08),
        "num_shelves": int(rng.integers(2, 6)),
        "num_door_shelves": int(rng.integers(0, 4)),
        "handle_left": bool(rng.random() < 0.5),
        "handle_vertical": bool(rng.random() < 0.7),
        "handle_length": rng.uniform(0.15, 0.3),
        "handle_thickness": rng.uniform(0.03, 0.07),
        "handle_depth": rng.uniform(0.03, 0.06),
        "handle_shape_args": handle_shape(rng, folder),
        "door_shape_args": {
            "straight_ratio": rng.uniform(0.7, 0.95), "curvature_ratio": rng.uniform(0.5, 1.0),
            "num_segments": int(rng.integers(5, 12)), "tmp_mesh_dir": folder,
        },
    }  # fmt: skip


def microwave(rng: np.random.Generator, folder: str) -> Arguments:
    """A microwave oven."""
    box = size(rng, (0.42, 0.65), (0.3, 0.5), (0.24, 0.4))
    return box | {
        "thickness": rng.uniform(0.02, 0.05),
        "display_panel_width": rng.uniform(0.15, 0.3) * box["width"],
        "handle_left": bool(rng.random() < 0.5),
        "handle_depth": rng.uniform(0.03, 0.07),
        "handle_thickness": rng.uniform(0.02, 0.05),
        "handle_length": rng.uniform(0.4, 0.8) * box["height"],
        "handle_straight_ratio": rng.uniform(0.3, 0.9),
        "handle_curvature_ratio": rng.uniform(0.3, 1.0),
        "tmp_mesh_dir": folder,
    }


def oven_range(rng: np.random.Generator, folder: str) -> Arguments:
    """A kitchen range: an oven with a drawer below it."""
    box = size(rng, (0.55, 0.9), (0.55, 0.8), (0.8, 1.0))
    panel, storage = rng.uniform(0.08, 0.14), rng.uniform(0.12, 0.25)
    return box | {
        "control_panel_height": panel,
        "storage_height": storage,
        "oven_height": box["height"] - panel - storage,
        "wall_thickness": rng.uniform(0.015, 0.04),
        "handle_length": rng.uniform(0.5, 0.9) * box["width"],
        "handle_thickness": rng.uniform(0.025, 0.045),
        "handle_depth": rng.uniform(0.025, 0.05),
        "handle_shape_args": handle_shape(rng, folder),
        "door_shape_args": {
            "use_primitives": True,
            "trim_width_ratio": rng.uniform(0.2, 0.4),
            "inner_depth_ratio": rng.uniform(0.1, 0.5),
        },
    }


def dishwasher(rng: np.random.Generator, folder: str) -> Arguments:
    """A dishwasher with two baskets."""
    box = size(rng, (0.45, 0.75), (0.55, 0.8), (0.75, 1.0))
    return box | {
        "control_panel_height": rng.uniform(0.08, 0.14),
        "foot_panel_height": rng.uniform(0.03, 0.1),
        "wall_thickness": rng.uniform(0.015, 0.03),
        "door_thickness": rng.uniform(0.03, 0.06),
        "basket_height": rng.uniform(0.1, 0.18),
        "basket_wire_mesh_gap": rng.uniform(0.04, 0.09),
        "handle_length": rng.uniform(0.4, 0.9) * box["width"],
        "handle_thickness": rng.uniform(0.025, 0.05),
        "handle_depth": rng.uniform(0.025, 0.05),
        "handle_shape_args": handle_shape(rng, folder),
    }


def sink_cabinet(rng: np.random.Generator, folder: str) -> Arguments:
    """A cabinet with doors below a sink."""
    box = size(rng, (0.6, 1.0), (0.55, 0.8), (0.8, 1.0))
    return box | cabinet_fittings(rng, folder) | {
        "sink_width": rng.uniform(0.5, 0.75) * box["width"],
        "sink_depth": rng.uniform(0.5, 0.65) * box["depth"],
        "sink_height": rng.uniform(0.15, 0.22) * box["height"],
        "wall_thickness": rng.uniform(0.015, 0.025),
        "sink_tmp_mesh_dir": folder,
    }  # fmt: skip


def base_cabinet(rng: np.random.Generator, folder: str) -> Arguments:
    """A kitchen cabinet with drawers above doors."""
    doors = int(rng.integers(0, 4))
    types = tuple(str(name) for name in rng.choice(["door_left", "door_right"], doors))
    return size(rng, (0.4, 1.2), (0.5, 0.8), (0.75, 1.0)) | cabinet_fittings(rng, folder) | {
        "lower_compartment_types": types,
        "num_drawers_vertical": int(rng.integers(0, 3) if doors else rng.integers(1, 4)),
        "num_drawers_horizontal": 1 if not doors or rng.random() < 0.5 else None,
        "num_shelves": int(rng.integers(1, 4)),
        "foot_panel_height": rng.uniform(0.03, 0.1),
        "wall_thickness": rng.uniform(0.012, 0.025),
    }  # fmt: skip


def wall_cabinet(rng: np.random.Generator, folder: str) -> Arguments:
    """A wall cabinet with one to three doors."""
    doors = int(rng.integers(1, 4))
    types = tuple(str(name) for name in rng.choice(["door_left", "door_right"], doors))
    return size(rng, (0.3 * doors, 0.45 * doors), (0.25, 0.45), (0.5, 1.0)) | cabinet_fittings(rng, folder) | {
        "compartment_types": types,
        "num_shelves": int(rng.integers(0, 4)),
        "wall_thickness": rng.uniform(0.008, 0.02),
    }  # fmt: skip


def kitchen_island(rng: np.random.Generator, folder: str) -> Arguments:
    """A kitchen island with drawers and doors."""
    box = size(rng, (1.0, 1.8), (0.6, 1.0), (0.8, 1.0))
    return box | cabinet_fittings(rng, folder) | {
        "depth_storage": rng.uniform(0.45, 0.7) * box["depth"],
        "depth_side_storage": rng.uniform(0.06, 0.1) * box["width"],
        "countertop_thickness": rng.uniform(0.02, 0.05),
    }  # fmt: skip


def cabinet(rng: np.random.Generator, folder: str) -> Arguments:
    """A cabinet with a grid of compartments: drawers, doors that open to any side, open and closed ones."""
    return _compartments(rng, ["open", "closed", "door_left", "door_right", "door_top", "door_bottom", "drawer", "drawer"]) | {
        **cabinet_fittings(rng, folder),
        "outer_wall_thickness": rng.uniform(0.01, 0.03),
        "inner_wall_thickness": rng.uniform(0.008, 0.02),
        "frontboard_thickness": rng.uniform(0.012, 0.025),
        "frontboard_overlap": float(rng.choice([0.0, 1.0])),
    }


def cubby_shelf(rng: np.random.Generator, folder: str) -> Arguments:
    """A shelf of separate boxes, some with doors."""
    return _compartments(rng, ["open", "closed", "door_left", "door_right", "door_top", "door_bottom"]) | {
        **cabinet_fittings(rng, folder),
        "wall_thickness": rng.uniform(0.008, 0.02),
    }


def _compartments(rng: np.random.Generator, types: list[str]) -> Arguments:
    """Size and compartments of a cabinet. At least one moves."""
    columns, rows = int(rng.integers(1, 4)), int(rng.integers(1, 5))
    moving = [name for name in types if name not in ("open", "closed")]
    chosen = [str(name) for name in rng.choice(types, columns * rows)]
    chosen[int(rng.integers(len(chosen)))] = str(rng.choice(moving))
    return {
        "width": rng.uniform(0.35, 0.6) * columns,
        "depth": rng.uniform(0.3, 0.6),
        "height": rng.uniform(0.25, 0.45) * rows,
        "compartment_mask": np.arange(columns * rows).reshape(rows, columns).tolist(),
        "compartment_types": chosen,
        "compartment_widths": rng.uniform(0.7, 1.3, columns),
        "compartment_heights": rng.uniform(0.7, 1.3, rows),
    }


def partitioned_cabinet(rng: np.random.Generator, folder: str) -> Arguments:
    """A cabinet that is split at random into drawers, doors and open compartments."""
    knob = rng.uniform(0.02, 0.05)
    return size(rng, (0.6, 1.6), (0.35, 0.6), (0.6, 1.8)) | {
        "thickness": rng.uniform(0.015, 0.025),
        "split_decay": rng.uniform(0.5, 0.7),
        "handle_types": [str(rng.choice(["procedural", "box", "knob"]))],
        "knob_kwargs": {"width": knob, "height": knob, "depth": rng.uniform(0.03, 0.06), "tmp_mesh_dir": folder},
        "handle_shape_args": handle_shape(rng, folder),
        "handle_width": rng.uniform(0.08, 0.2),
        "seed": int(rng.integers(2**31)),
    }


def cnc_machine(rng: np.random.Generator, folder: str) -> Arguments:
    """A milling machine with a sliding door. One in three has push buttons, eleven each."""
    return size(rng, (3.5, 6.0), (2.2, 3.5), (1.8, 2.6)) | {
        "handle_length": rng.uniform(0.4, 0.8),
        "handle_thickness": rng.uniform(0.04, 0.07),
        "handle_depth": rng.uniform(0.1, 0.2),
        "handle_shape_args": handle_shape(rng, folder),
        "button_size": rng.uniform(0.025, 0.045) if rng.random() < 1 / 3 else None,
        "window_size": float(rng.choice([0.0, rng.uniform(0.3, 0.8)])),
    }


def lever_switch(rng: np.random.Generator, folder: str) -> Arguments:
    """A lever that tips in a small base."""
    reach = rng.uniform(0.3, 0.9)
    return {
        "lever_length": rng.uniform(0.05, 0.2),
        "lever": str(rng.choice(["box", "cylinder"])),
        "tip": [None, "cylinder", "sphere"][int(rng.integers(3))],
        "base": True,
        "joint_limit_lower": -reach,
        "joint_limit_upper": reach,
    }


def safety_switch(rng: np.random.Generator, folder: str) -> Arguments:
    """A fuse box with a lever at its side."""
    return lever_switch(rng, folder) | {
        "fuse_box_width": rng.uniform(0.15, 0.35),
        "fuse_box_depth": rng.uniform(0.08, 0.18),
        "fuse_box_height": rng.uniform(0.25, 0.5),
        "lever_right_of_box": bool(rng.random() < 0.5),
        "tmp_mesh_dir": folder,
    }


STORAGE = "StorageFurniture"
ASSETS = {
    "refrigerator": Asset("RefrigeratorAsset", "Refrigerator", refrigerator),
    "microwave": Asset("MicrowaveAsset", "Microwave", microwave),
    "range": Asset("RangeAsset", "Oven", oven_range),
    "dishwasher": Asset("DishwasherAsset", "Dishwasher", dishwasher),
    "sink_cabinet": Asset("SinkCabinetAsset", STORAGE, sink_cabinet),
    "base_cabinet": Asset("BaseCabinetAsset", STORAGE, base_cabinet),
    "wall_cabinet": Asset("WallCabinetAsset", STORAGE, wall_cabinet),
    "kitchen_island": Asset("KitchenIslandAsset", STORAGE, kitchen_island),
    "cabinet": Asset("CabinetAsset", STORAGE, cabinet),
    "cubby_shelf": Asset("CubbyShelfAsset", STORAGE, cubby_shelf),
    "partitioned_cabinet": Asset("RecursivelyPartitionedCabinetAsset", STORAGE, partitioned_cabinet, "y"),
    "cnc_machine": Asset("CNCMachineAsset", "milling_machine", cnc_machine, "y"),
    "lever_switch": Asset("LeverSwitchAsset", "Switch", lever_switch),
    "safety_switch": Asset("SafetySwitchAsset", "Switch", safety_switch),
}
"""The articulated assets by name. Files do not state fronts; each is the side that drawers, doors and buttons are on."""


def make_object(name: str, seed: int) -> UrdfObject:
    """Build one object.

    Args:
        name: Name of the asset, a key of `ASSETS`.
        seed: Seed of the parameters. The same asset and seed give the same object.

    Returns:
        The object with all joints at zero.
    """
    from scene_synthesizer import procedural_assets

    asset = ASSETS[name]
    rng = np.random.default_rng([seed, *name.encode()])
    with tempfile.TemporaryDirectory() as folder:
        arguments = asset.draw(rng, folder)
        model = getattr(procedural_assets, asset.class_name)(**arguments)._model
        links = {link.name: _pieces(link) for link in model.robot.links}
    facts = {
        "category": asset.category, "asset": asset.class_name, "generator": "scene_synthesizer",
        "version": metadata.version("scene_synthesizer"), "licence": "Apache-2.0", "seed": seed,
        "up": "z", "front": asset.front,
        "parameters": {key: _without_folder(value) for key, value in arguments.items() if "tmp" not in key},
    }  # fmt: skip
    return UrdfObject(links, [_connection(joint) for joint in model.robot.joints], facts)


def _without_folder(value: Any) -> Any:
    """The value of an argument without the folder of intermediate meshes."""
    return {key: inner for key, inner in value.items() if "tmp" not in key} if isinstance(value, dict) else value


def _pieces(link: Any) -> list[Piece]:
    """A piece for each visual element of a link."""
    import trimesh

    pieces = []
    for number, visual in enumerate(link.visuals):
        shape = visual.geometry
        mesh: Any  # trimesh's stubs do not know its attributes
        if shape.mesh is not None:
            mesh = trimesh.load(shape.mesh.filename, force="mesh", process=False)
            mesh.apply_scale(1.0 if shape.mesh.scale is None else shape.mesh.scale)
        elif shape.box is not None:
            mesh = trimesh.creation.box(shape.box.size)
        elif shape.cylinder is not None:
            mesh = trimesh.creation.cylinder(shape.cylinder.radius, shape.cylinder.length)
        else:
            mesh = trimesh.creation.icosphere(radius=shape.sphere.radius)
        if visual.origin is not None:
            mesh.apply_transform(visual.origin)
        pieces.append(Piece(visual.name or f"{link.name}_{number}", mesh.vertices, mesh.faces))
    return pieces


def _connection(joint: Any) -> Connection:
    pose = np.eye(4) if joint.origin is None else np.asarray(joint.origin, float)
    axis = np.array([1.0, 0.0, 0.0]) if joint.axis is None else np.asarray(joint.axis, float)
    limits = None if joint.limit is None else (joint.limit.lower, joint.limit.upper)
    rpy = Rotation.from_matrix(pose[:3, :3]).as_euler("xyz").tolist()
    unit = (axis / np.linalg.norm(axis)).tolist()
    return Connection(joint.name, joint.type, joint.parent, joint.child, pose[:3, 3].tolist(), rpy, unit, limits)


def main() -> int:
    """Write the objects, and print the number of each asset."""
    args = collector_parser(__doc__, list(ASSETS)).parse_args()
    for name in args.assets:
        for seed in range(args.seed, args.seed + args.count):
            write_urdf_object(args.out / f"{name}-{seed:04d}", make_object(name, seed))
        print(f"{name}: {args.count} objects", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
