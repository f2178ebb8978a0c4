"""What a depth camera sees of an object in many poses: by kinmo's z-buffer, or by PyBullet."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from types import TracebackType
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo import _core
from kinmo.scans.camera import Camera
from kinmo.shape import Mesh

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
    """PyBullet's TinyRenderer, as the paper's pipeline uses it: the reference that `RasterRenderer` is checked against."""

    def __init__(self, meshes: Sequence[Mesh]) -> None:
        import pybullet
        from pybullet_utils.bullet_client import BulletClient

        self._client = BulletClient(pybullet.DIRECT)
        self._bodies = [self._body(mesh) for mesh in meshes]

    def _body(self, mesh: Mesh) -> int:
        bullet = self._client
        visual = bullet.createVisualShape(
            bullet.GEOM_MESH,
            vertices=mesh.vertices.tolist(),
            indices=mesh.faces.ravel().tolist(),
            flags=bullet.VISUAL_SHAPE_DOUBLE_SIDED,
        )
        return int(bullet.createMultiBody(baseMass=0.0, baseVisualShapeIndex=visual))

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._client.disconnect()

    def render(self, poses: F64, camera: Camera) -> DepthImages:
        shape = (len(poses), camera.height, camera.width)
        images = DepthImages(np.zeros(shape, np.float32), np.full(shape, NOTHING, np.int32))
        for frame, parts in enumerate(poses):
            for body, pose in zip(self._bodies, parts, strict=True):
                turn = Rotation.from_matrix(pose[:3, :3]).as_quat()
                self._client.resetBasePositionAndOrientation(body, pose[:3, 3].tolist(), turn.tolist())
            images.depths[frame], images.parts[frame] = self._picture(camera)
        return images

    def _picture(self, camera: Camera) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        """The camera stands at the origin of the world, and looks along +z with -y up."""
        bullet = self._client
        left, bottom = -camera.center[0] / camera.focal[0], (camera.center[1] - camera.height) / camera.focal[1]
        right, top = (camera.width - camera.center[0]) / camera.focal[0], camera.center[1] / camera.focal[1]
        _, _, _, buffer, seen = bullet.getCameraImage(
            camera.width,
            camera.height,
            viewMatrix=bullet.computeViewMatrix([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]),
            projectionMatrix=bullet.computeProjectionMatrix(
                left * camera.near, right * camera.near, bottom * camera.near, top * camera.near, camera.near, camera.far
            ),
            renderer=bullet.ER_TINY_RENDERER,
            flags=bullet.ER_SEGMENTATION_MASK_OBJECT_AND_LINKINDEX,
            shadow=0,
        )
        shape = (camera.height, camera.width)
        bodies = np.asarray(seen, np.int64).reshape(shape) & ((1 << 24) - 1)
        parts = np.where(np.asarray(seen).reshape(shape) < 0, NOTHING, np.searchsorted(self._bodies, bodies))
        share = np.asarray(buffer, np.float64).reshape(shape)
        near, far = camera.near, camera.far
        depths = near * far / (far - (far - near) * share)
        return np.where(parts < 0, 0.0, depths).astype(np.float32), parts.astype(np.int32)
