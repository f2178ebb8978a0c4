"""Small datasets on disk in the formats of PartNet-Mobility, PartNet and DSG-Net."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

BOX = ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
QUADS = [[1, 2, 4, 3], [5, 7, 8, 6], [1, 5, 6, 2], [3, 4, 8, 7], [1, 3, 7, 5], [2, 6, 8, 4]]

RESULT = [
    {
        "id": 0,
        "name": "storage_furniture",
        "text": "Storage furniture",
        "children": [
            {
                "id": 1,
                "name": "cabinet_frame",
                "text": "Frame",
                "children": [
                    {"id": 2, "name": "vertical_side_panel", "text": "Panel", "objs": ["original-1", "original-2"]},
                    {"id": 3, "name": "back_panel", "text": "Back", "objs": ["original-3"]},
                ],
            },
            {
                "id": 4,
                "name": "cabinet_door",
                "text": "Door",
                "children": [
                    {"id": 5, "name": "cabinet_door_surface", "text": "Surface", "objs": ["original-4"]},
                    {"id": 6, "name": "handle", "text": "Handle", "objs": ["original-5"]},
                ],
            },
            {"id": 7, "name": "drawer", "text": "Drawer", "objs": ["original-6"]},
        ],
    }
]
BOXES = {
    "original-1": ((-0.5, 0.0, -0.4), (-0.45, 1.0, 0.4)),
    "original-2": ((0.45, 0.0, -0.4), (0.5, 1.0, 0.4)),
    "original-3": ((-0.45, 0.0, -0.4), (0.45, 1.0, -0.38)),
    "original-4": ((-0.45, 0.5, 0.38), (0.45, 1.0, 0.4)),
    "original-5": ((0.35, 0.7, 0.4), (0.4, 0.8, 0.45)),
    "original-6": ((-0.45, 0.0, -0.3), (0.45, 0.48, 0.4)),
}
LEAVES = {2: ("original-1", "original-2"), 3: ("original-3",), 5: ("original-4",), 6: ("original-5",), 7: ("original-6",)}
META = {"model_cat": "StorageFurniture", "anno_id": "4711"}


def joint_data(direction: Sequence[float], a: float = 0, b: float = 90, **limit: Any) -> dict[str, Any]:
    """The field jointData of a joint through (-0.45, 0.5, 0.38)."""
    return {
        "axis": {"origin": [-0.45, 0.5, 0.38], "direction": list(direction)},
        "limit": {"a": a, "b": b, "noLimit": False, **limit},
    }


def mobility() -> list[dict[str, Any]]:
    """The content of mobility_v2.json: a frame, a door that rotates about y, and a drawer that slides along z."""
    return [
        {
            "id": 0,
            "parent": -1,
            "joint": "heavy",
            "name": "cabinet_frame",
            "parts": [{"id": 1, "name": "cabinet_frame"}],
            "jointData": {},
        },
        {
            "id": 1,
            "parent": 0,
            "joint": "hinge",
            "name": "door",
            "parts": [{"id": 5, "name": "surface"}, {"id": 6, "name": "handle"}],
            "jointData": joint_data((0, -1, 0)),
        },
        {
            "id": 2,
            "parent": 0,
            "joint": "slider",
            "name": "drawer",
            "parts": [{"id": 7, "name": "drawer"}],
            "jointData": joint_data((0, 0, 1), 0, 0.6, rotates=False),
        },
    ]


def box_obj(low: Sequence[float], high: Sequence[float]) -> str:
    """The OBJ text of a box of six quads, with texture and normal indices as in real files."""
    lines = ["# a box", "mtllib box.mtl", "o box"]
    lines += [f"v {x} {y} {z}" for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    lines += ["vt 0 0", "vn 0 1 0", "usemtl none"]
    lines += ["f " + " ".join(f"{corner}/1/1" for corner in quad) for quad in QUADS]
    return "\n".join(lines) + "\n"


def write_json(path: Path, value: Any) -> Path:
    """Write a JSON file and the folders above it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(value), encoding="utf-8")
    return path


def write_meshes(folder: Path) -> None:
    """Write the OBJ files of all boxes."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, (low, high) in BOXES.items():
        (folder / f"{name}.obj").write_text(box_obj(low, high))


def write_partnet(
    folder: Path, result: Any = None, meta: Any = None, *, file: str = "result.json", meshes: str = "objs"
) -> Path:
    """Write a shape in the format of PartNet. Returns its folder."""
    write_meshes(folder / meshes)
    write_json(folder / file, RESULT if result is None else result)
    write_json(folder / "meta.json", META if meta is None else meta)
    return folder


def write_partnet_mobility(folder: Path, bodies: Any = None, result: Any = None, meta: Any = None) -> Path:
    """Write a shape in the format of PartNet-Mobility. Returns its folder."""
    write_partnet(folder, result, meta, meshes="textured_objs")
    write_json(folder / "mobility_v2.json", mobility() if bodies is None else bodies)
    return folder


def tree(node: dict[str, Any]) -> dict[str, Any]:
    """A node of RESULT in the format of StructureNet."""
    box = [0.0, 0.5, 0.0, 1.0, 1.0, 0.8, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    out: dict[str, Any] = {"id": node["id"], "label": node["name"], "box": box}
    if "children" in node:
        out |= {"children": [tree(child) for child in node["children"]], "edges": []}
    return out


def points_on_box(low: Sequence[float], high: Sequence[float], count: int, seed: int) -> np.ndarray:
    """Random points [count, 3] on the surface of a box."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(low, high, (count, 3))
    axis = rng.integers(0, 3, count)
    points[np.arange(count), axis] = np.where(rng.random(count) < 0.5, np.array(low)[axis], np.array(high)[axis])
    return points


def write_dsg_net(root: Path, name: str = "4711", *, geometry: str = "obj") -> Path:
    """Write a shape in the format of DSG-Net. `geometry` is "obj", "geo" (points) or "none". Returns the tree file."""
    if geometry == "obj":
        for leaf, meshes in LEAVES.items():
            path = root / "storagefurniture_obj" / name / f"{leaf}.obj"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(box_obj(*BOXES[meshes[0]]))
    elif geometry == "geo":
        parts = np.zeros((8, 1000, 3), np.float32)
        for leaf, meshes in LEAVES.items():
            parts[leaf] = points_on_box(*BOXES[meshes[0]], 1000, leaf)
        (root / "storagefurniture_geo").mkdir(parents=True, exist_ok=True)
        np.savez(root / "storagefurniture_geo" / f"{name}.npz", parts=parts)
    return write_json(root / "storagefurniture_hier" / f"{name}.json", tree(RESULT[0]))
