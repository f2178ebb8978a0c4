"""Depth and part-id images of an object in many poses, by kinmo's z-buffer or by PyBullet."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType
from typing import Literal, Protocol

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo import _core
from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh
from kinmo.scans.rendering.pinhole_camera import Camera

F64 = NDArray[np.float64]

NO_PART = -1
"""Part id of pixels and points that are on no part of the object."""
TINY_RENDERER_SHIFT = np.array([-0.5, 0.5])
"""Sampling offset of TinyRenderer in pixels, to the right and down."""
BODY_MASK = (1 << 24) - 1
"""Bits of a segmentation id that hold the body; the bits above hold the link."""


@dataclass(frozen=True, eq=False)
class DepthImages:
    """F images: `depths` [F, height, width] float32 along z (0: empty) and `parts` int32 (`NO_PART`: empty)."""

    depths: NDArray[np.float32]
    parts: NDArray[np.int32]


class Renderer(AbstractContextManager["Renderer"], Protocol):
    """Renderer of the part meshes of one object; a context manager that frees what it holds outside Python."""

    def render(self, poses: F64, camera: Camera) -> DepthImages:
        """Render F images, from poses [F, K, 4, 4] of each part's frame in the camera frame."""

    def __exit__(self, *error: object) -> None:
        return


def open_renderer(name: Literal["raster", "pybullet"], meshes: Sequence[Mesh]) -> Renderer:
    """Open a renderer by its name: `raster` (kinmo's z-buffer) or `pybullet` (the paper's)."""
    return RasterRenderer(meshes) if name == "raster" else PybulletRenderer(meshes)


class RasterRenderer(Renderer):
    """Z-buffer of the Rust core: exact depths at pixel centers, both sides of every triangle."""

    def __init__(self, meshes: Sequence[Mesh]) -> None:
        self._meshes = _core.Meshes([mesh.vertices for mesh in meshes], [mesh.faces for mesh in meshes])

    def render(self, poses: F64, camera: Camera) -> DepthImages:
        size = (camera.width, camera.height)
        return DepthImages(
            *_core.render(self._meshes, poses, size, camera.focal, camera.center, near=camera.near, far=camera.far)
        )


class PybulletRenderer(Renderer):
    """PyBullet's TinyRenderer, as in the paper's pipeline: the reference that `RasterRenderer` is checked against.

    TinyRenderer culls back faces, whatever its flags. `both_sides` adds each triangle a second time, reversed.
    """

    def __init__(self, meshes: Sequence[Mesh], both_sides: bool = True) -> None:
        self._bullet = pybullet = _pybullet()
        self._client = pybullet.connect(pybullet.DIRECT)
        self._bodies = [self._body(mesh, both_sides) for mesh in meshes]

    def _body(self, mesh: Mesh, both_sides: bool) -> int:
        faces = np.concatenate([mesh.faces, mesh.faces[:, ::-1]]) if both_sides else mesh.faces
        # A file, because PyBullet limits the size of meshes that are passed in memory.
        with TemporaryDirectory() as folder:
            path = Path(folder) / "part.obj"
            trimesh.Trimesh(mesh.vertices, faces, process=False).export(path, digits=16)
            visual = self._bullet.createVisualShape(self._bullet.GEOM_MESH, fileName=str(path), physicsClientId=self._client)
        return int(self._bullet.createMultiBody(0.0, baseVisualShapeIndex=visual, physicsClientId=self._client))

    def __exit__(self, *error: object) -> None:
        self._bullet.disconnect(self._client)

    def render(self, poses: F64, camera: Camera) -> DepthImages:
        shape = (len(poses), camera.height, camera.width)
        images = DepthImages(np.zeros(shape, np.float32), np.full(shape, NO_PART, np.int32))
        view, projection = self._matrices(camera)
        for frame, parts in enumerate(poses):
            for body, pose in zip(self._bodies, parts, strict=True):
                turn = Rotation.from_matrix(pose[:3, :3]).as_quat()
                self._bullet.resetBasePositionAndOrientation(
                    body, pose[:3, 3].tolist(), turn.tolist(), physicsClientId=self._client
                )
            images.depths[frame], images.parts[frame] = self._image(camera, view, projection)
        return images

    def _matrices(self, camera: Camera) -> tuple[list[float], list[float]]:
        """View and projection matrix of a camera at the world's origin that looks along +z, with -y up."""
        # Pixel (column i, row j) of TinyRenderer samples the image at (i, j + 1) rather than (i + 1/2, j + 1/2).
        middle = camera.center + TINY_RENDERER_SHIFT
        left, right = -middle[0] / camera.focal[0], (camera.width - middle[0]) / camera.focal[0]
        bottom, top = (middle[1] - camera.height) / camera.focal[1], middle[1] / camera.focal[1]
        sides = (camera.near * side for side in (left, right, bottom, top))
        projection = self._bullet.computeProjectionMatrix(*sides, camera.near, camera.far)
        return self._bullet.computeViewMatrix([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]), projection

    def _image(
        self, camera: Camera, view: list[float], projection: list[float]
    ) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        _, _, _, buffer, mask = self._bullet.getCameraImage(
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
        ids = np.asarray(mask, np.int64).reshape(shape)
        parts = np.where(ids < 0, NO_PART, np.searchsorted(self._bodies, ids & BODY_MASK))
        share = np.asarray(buffer, np.float64).reshape(shape)
        depths = camera.near * camera.far / (camera.far - (camera.far - camera.near) * share)
        return np.where(parts < 0, 0.0, depths).astype(np.float32), parts.astype(np.int32)


def _pybullet() -> ModuleType:
    """Import PyBullet without the build date that it prints on standard error."""
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        import pybullet
    except ImportError as error:
        problem = 'PyBullet is not installed (it has wheels for Python 3.10 and 3.11 only); use "raster", the images agree'
        raise InputError("scans.renderer", problem) from error
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)
    module: ModuleType = pybullet
    return module
