"""Samples of an object as its looks are, with glass in front of what is behind it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh
from kinmo.view.picture_raster import Camera
from kinmo.view.studio_picture import lit
from kinmo.view.surface_colors import Note, SurfaceColors
from kinmo.view.surface_raster import Fragments, SurfaceRaster

F64 = NDArray[np.float64]


class DrawnLooks:
    """Parts that can be drawn with their materials, images and colours of vertices.

    Of the surfaces of one body that show what is behind them, only the nearest one is drawn.

    Args:
        meshes: The surface of each part.
        bodies: Number of the body of each part.
        note: What receives a line about an image that cannot be shown.
    """

    def __init__(self, meshes: Sequence[Mesh], bodies: Sequence[int], note: Note = lambda line: None) -> None:
        self._bodies = bodies
        self._colors = SurfaceColors(meshes, note)
        faint = self._colors.is_see_through
        self._glass: list[tuple[list[int], SurfaceRaster, SurfaceColors]] = []
        if faint.any():
            shares = np.split(faint, np.cumsum([len(mesh.faces) for mesh in meshes])[:-1])
            for body in dict.fromkeys(bodies):
                own = [part for part, share in enumerate(shares) if bodies[part] == body and share.any()]
                if own:
                    clear = [meshes[part].part(shares[part]) for part in own]
                    self._glass.append((own, SurfaceRaster(clear), SurfaceColors(clear)))
            meshes = [mesh.part(~share) for mesh, share in zip(meshes, shares, strict=True)]
            self._colors = SurfaceColors(meshes)
        self._raster = SurfaceRaster(meshes)

    def draw(self, camera: Camera, poses: F64, samples: int, ranks: Sequence[int]) -> tuple[F64, Fragments]:
        """RGBA samples [height, width, 4] in 0..1, and what is seen of the surfaces that let nothing through.

        Args:
            camera: The camera.
            poses: Pose [P, 4, 4] of every part.
            samples: Samples along each side of a pixel.
            ranks: Rank of every part, as in `SurfaceRaster.render`.
        """
        seen = self._raster.render(camera, poses, samples, ranks)
        image = lit(seen, self._colors.at(seen), self._bodies, has_creases=False)
        depths, layers = [], []
        for parts, raster, colors in self._glass:
            own = raster.render(camera, poses[parts], samples, [ranks[part] for part in parts])
            depths.append(np.where(own.depths < seen.depths, own.depths, np.inf))
            layers.append(lit(own, colors.at(own), [self._bodies[part] for part in parts], has_creases=False))
        return (_over(image, depths, layers) if layers else image), seen


def _over(image: F64, depths: Sequence[F64], layers: Sequence[F64]) -> F64:
    """An RGBA image with layers over it, the farthest one first. A layer is not drawn where its depth is infinite."""
    rows, columns = np.nonzero(np.isfinite(np.min(depths, axis=0)))
    far = np.stack([depth[rows, columns] for depth in depths])
    over = np.stack([layer[rows, columns] for layer in layers])
    over[..., 3] *= np.isfinite(far)
    order = np.argsort(-far, axis=0)
    under = image[rows, columns]
    for places in order:
        top = over[places, np.arange(len(rows))]
        kept = under[:, 3:] * (1.0 - top[:, 3:])
        opacity = top[:, 3:] + kept
        color = (top[:, :3] * top[:, 3:] + under[:, :3] * kept) / np.maximum(opacity, np.finfo(float).tiny)
        under = np.concatenate([color, opacity], axis=1)
    result = image.copy()
    result[rows, columns] = under
    return np.asarray(result)
