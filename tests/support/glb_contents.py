"""The contents of a GLB: its document, arrays, and the nodes' transforms at any time of an animation."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

DTYPES = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


class GlbContents:
    """A GLB. `document` is its JSON."""

    def __init__(self, data: bytes) -> None:
        magic, version, length = struct.unpack_from("<4sII", data)
        assert (magic, version, length) == (b"glTF", 2, len(data))
        chunks, begin = {}, 12
        while begin < length:
            size, kind = struct.unpack_from("<I4s", data, begin)
            assert size % 4 == 0
            chunks[kind] = data[begin + 8 : begin + 8 + size]
            begin += 8 + size
        self.document: dict[str, Any] = json.loads(chunks[b"JSON"])
        self.binary = chunks.get(b"BIN\0", b"")

    def array(self, index: int) -> np.ndarray:
        """The array [count, width] of an accessor."""
        accessor = self.document["accessors"][index]
        view, dtype = self.document["bufferViews"][accessor["bufferView"]], np.dtype(DTYPES[accessor["componentType"]])
        width = WIDTHS[accessor["type"]]
        assert view["byteOffset"] % dtype.itemsize == 0 and view["byteLength"] == accessor["count"] * width * dtype.itemsize
        found = np.frombuffer(self.binary, dtype, accessor["count"] * width, view["byteOffset"]).reshape(-1, width)
        if "min" in accessor:
            assert (found.min(axis=0) == accessor["min"]).all() and (found.max(axis=0) == accessor["max"]).all()
        return found

    def image(self, index: int) -> bytes:
        """The encoded image in a buffer view."""
        view = self.document["bufferViews"][self.document["images"][index]["bufferView"]]
        return self.binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]

    def local_pose(self, node: int, moments: dict[str, float]) -> np.ndarray:
        """Transform [4, 4] of a node to its parent, with some animations, by name, at a time in seconds."""
        entry, pose = self.document["nodes"][node], np.eye(4)
        pose[:3, 3] = entry.get("translation", (0, 0, 0))
        for animation in self.document.get("animations", []):
            for channel in animation["channels"]:
                if channel["target"]["node"] != node or animation["name"] not in moments:
                    continue
                sampler = animation["samplers"][channel["sampler"]]
                times, states = self.array(sampler["input"])[:, 0], self.array(sampler["output"])
                assert (np.diff(times) > 0.0).all()
                time = np.clip(moments[animation["name"]], times[0], times[-1])
                if channel["target"]["path"] == "rotation":
                    turns = Rotation.from_quat(states)
                    pose[:3, :3] = (turns[0] if len(times) == 1 else Slerp(times, turns)(time)).as_matrix()
                else:
                    pose[:3, 3] = [np.interp(time, times, column) for column in states.T]
        return pose

    def poses(self, moments: dict[str, float]) -> dict[str, np.ndarray]:
        """Transforms [4, 4] of the nodes with children or joints to the scene, by name, as in `local_pose`."""
        found = {}
        pending = [(root, np.eye(4)) for root in self.document["scenes"][self.document["scene"]]["nodes"]]
        while pending:
            node, above = pending.pop()
            pose = above @ self.local_pose(node, moments)
            found[node] = pose
            pending += [(child, pose) for child in self.document["nodes"][node].get("children", [])]
        assert len(found) == len(self.document["nodes"])
        return {entry["name"]: found[i] for i, entry in enumerate(self.document["nodes"]) if "mesh" not in entry}
