"""What a depth camera sees of an object in many poses: by kinmo's z-buffer, or by PyBullet."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType, TracebackType
from typing import Literal, Protocol

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo import _core
from kinmo.core.shape import Mesh
from kinmo.scans.camera import Camera

F64 = NDArray[np.float64]

NOTHING = -1
"""Part id of a pixel that sees nothing."""

RendererName = Literal["raster", "pybullet"]


@dataclass(frozen=True, eq=False)
class DepthImages:
    """F pictures: `depths` [F, height, width] float32 along z (0 where nothing is), `parts` int32 (`NOTHING` there)."""

    depths: NDArray[np.float32]
    parts: NDArray[np.int32]


class Renderer(AbstractContextManager["Renderer"], Protocol):
    """Holds the meshes of an object's parts; a context manager, for what is held outside of Python."""

    def render(self, poses: F64, camera: Camera) -> DepthImages:
        """Pictures of the parts at `poses` [F, K, 4, 4], which take every part's frame to the camera's."""


def open_renderer(name: RendererName, meshes: Sequence[Mesh]) -> Renderer:
    """The renderer of that name."""
    return RasterRenderer(meshes) if name == "raster" else PybulletRenderer(meshes)


class RasterRenderer(Renderer):
    """kinmo's own: exact depths at the middles of the pixels, both sides of every triangle."""

    def __init__(self, meshes: Sequence[Mesh]) -> None:
        self._meshes = _core.Meshes([mesh.vertices for mesh in meshes], [mesh.faces for mesh in meshes])

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        pass

    def render(self, poses: F64, camera: Camera) -> DepthImages:
        size = (camera.width, camera.height)
        return DepthImages(
            *_core.render(self._meshes, poses, size, camera.focal, camera.center, near=camera.near, far=camera.far)
        )


class PybulletRenderer(Renderer):
    """PyBullet's TinyRenderer, as the paper's pipeline uses it: the reference that `RasterRenderer` is checked against.

    It sees triangles from the front alone, whatever its flags; with `both_sides` it is given each of them twice.
    """

    def __init__(self, meshes: Sequence[Mesh], both_sides: bool = True) -> None:
        self._bullet = pybullet = _pybullet()
        self._client = pybullet.connect(pybullet.DIRECT)
        self._bodies = [self._body(_from_both_sides(mesh) if both_sides else mesh) for mesh in meshes]

    def _body(self, mesh: Mesh) -> int:
        # by a file: what is handed over in memory may not be large
        with TemporaryDirectory() as folder:
            path = Path(folder) / "part.obj"
            trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).export(path, digits=16)
            visual = self._bullet.createVisualShape(
                self._bullet.GEOM_MESH,
                fileName=str(path),
                physicsClientId=self._client,
            )
        return int(self._bullet.createMultiBody(0.0, baseVisualShapeIndex=visual, physicsClientId=self._client))

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._bullet.disconnect(self._client)

    def render(self, poses: F64, camera: Camera) -> DepthImages:
        shape = (len(poses), camera.height, camera.width)
        images = DepthImages(np.zeros(shape, np.float32), np.full(shape, NOTHING, np.int32))
        view, projection = self._matrices(camera)
        for frame, parts in enumerate(poses):
            for body, pose in zip(self._bodies, parts, strict=True):
                turn = Rotation.from_matrix(pose[:3, :3]).as_quat()
                self._bullet.resetBasePositionAndOrientation(
                    body, pose[:3, 3].tolist(), turn.tolist(), physicsClientId=self._client
                )
            images.depths[frame], images.parts[frame] = self._picture(camera, view, projection)
        return images

    def _matrices(self, camera: Camera) -> tuple[list[float], list[float]]:
        """The camera stands at the origin of the world, and looks along +z with -y up."""
        # TinyRenderer's pixel (column i, row j) shows what is seen at (i, j + 1), not at (i + 1/2, j + 1/2)
        middle = camera.center + TINY_RENDERERS_SHIFT
        left, right = -middle[0] / camera.focal[0], (camera.width - middle[0]) / camera.focal[0]
        bottom, top = (middle[1] - camera.height) / camera.focal[1], middle[1] / camera.focal[1]
        sides = (camera.near * side for side in (left, right, bottom, top))
        projection = self._bullet.computeProjectionMatrix(*sides, camera.near, camera.far)
        return self._bullet.computeViewMatrix([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]), projection

    def _picture(
        self, camera: Camera, view: list[float], projection: list[float]
    ) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        _, _, _, buffer, seen = self._bullet.getCameraImage(
            camera.width,
            camera.height,
            viewMatrix=view,
            projectionMatrix=projection,
            renderer=self._bullet.ER_TINY_RENDERER,
            flags=self._bullet.ER_SEGMENTATION_MASK_OBJECT_AND_LINKINDEX,
            shadow=0,
            physicsClientId=self._client,
        )
        shape = (camera.height, camera.width)
        ids = np.asarray(seen, np.int64).reshape(shape)
        parts = np.where(ids < 0, NOTHING, np.searchsorted(self._bodies, ids & BODY_OF_ID))
        share = np.asarray(buffer, np.float64).reshape(shape)
        depths = camera.near * camera.far / (camera.far - (camera.far - camera.near) * share)
        return np.where(parts < 0, 0.0, depths).astype(np.float32), parts.astype(np.int32)


def _pybullet() -> ModuleType:
    """The module, which says on standard error when it was built, with that left out."""
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        import pybullet
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)
    found: ModuleType = pybullet
    return found


def _from_both_sides(mesh: Mesh) -> Mesh:
    return Mesh(mesh.vertices, np.concatenate([mesh.faces, mesh.faces[:, ::-1]]))


TINY_RENDERERS_SHIFT = np.array([-0.5, 0.5])
"""Pixels, to the right and down."""
BODY_OF_ID = (1 << 24) - 1
"""The bits of an id in the mask that are the body; those above are its link."""
