"""Previews of an object: at rest and with open joints, as one picture or as frames of an animation."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh, join
from kinmo.view.body_colors import RESTING
from kinmo.view.drawn_looks import DrawnLooks
from kinmo.view.object_scene import ObjectScene
from kinmo.view.picture_raster import SIDE, Camera, front_left
from kinmo.view.studio_picture import lit, pixels, shadow, with_axes
from kinmo.view.surface_colors import Note
from kinmo.view.surface_raster import SurfaceRaster

F64 = NDArray[np.float64]

PreviewColors = Literal["auto", "looks", "bodies"]
"""Colours of pictures: looks are those of the file, bodies one for each body, auto looks if they tell parts apart."""
UP = np.array([0.0, 1.0, 0.0])
MAX_SAMPLES = 4096
"""Largest number of samples along a side of a picture. So many take 3 GB."""
GAP = 0.04
"""Distance between the pictures of a strip, as a share of their size."""
AXIS_RADIUS, HEAD_RADIUS, HEAD_LENGTH = 0.006, 0.018, 0.055
"""Sizes of an axis and its head, in diagonals of the object."""
AXIS_SHADE = 0.55
"""Share of the colour of its body that an axis has."""
SWING = 0.5
"""Change of the viewer's place to both sides in an animation, for one unit along the front."""


@dataclass(frozen=True)
class PreviewStyle:
    """Style of pictures.

    Attributes:
        size: height of each picture in pixels.
        has_axes: True to draw the axes of the joints.
        has_shadow: True for a shadow on the ground.
        samples: samples along each side of a pixel; less in large pictures (`MAX_SAMPLES`).
        colors: colours of the surfaces.
        background: colour [3] behind the object, in 0..255. None for transparent pictures.
    """

    size: int = 480
    has_axes: bool = True
    has_shadow: bool = True
    samples: int = 3
    colors: PreviewColors = "auto"
    background: tuple[int, int, int] | None = (255, 255, 255)


class Preview:
    """An object that can be drawn in several poses.

    Args:
        scene: The object.
        style: What its pictures look like.
        note: What receives a line about an image that cannot be shown.

    Raises:
        InputError: The style names unknown colours.
    """

    def __init__(self, scene: ObjectScene, style: PreviewStyle = PreviewStyle(), note: Note = lambda line: None) -> None:
        self.scene, self.style = scene, style
        self._samples = max(1, min(style.samples, MAX_SAMPLES // style.size))
        self._owners = [(index, leaf) for index, body in enumerate(scene.bodies) for leaf in body.leaves]
        meshes = [scene.meshes[leaf] for _, leaf in self._owners]
        self._surfaces = SurfaceRaster(meshes)
        if style.colors not in get_args(PreviewColors):
            raise InputError("colors", f"expected one of {', '.join(get_args(PreviewColors))}, found {style.colors}")
        has_looks = scene.has_varied_looks if style.colors == "auto" else style.colors == "looks"
        self._looks = DrawnLooks(meshes, [index for index, _ in self._owners], note) if has_looks else None
        self._moving = [index for index, body in enumerate(scene.bodies) if body.joint is not None and body.parent is not None]
        arrows = [_arrow(scene.axis_ends(index), self._diagonal) for index in self._moving]
        self._axes = SurfaceRaster(arrows)

    def strip(self, poses: Sequence[Mapping[int, float]], *, begins_grey: bool = False) -> Image.Image:
        """One picture of the object in several poses, from left to right.

        Args:
            poses: Joint values by index of the body, for each pose.
            begins_grey: True to begin with the object at rest in grey, without axes.
        """
        shown: list[tuple[Mapping[int, float], bool]] = [({}, True)] * begins_grey + [(pose, False) for pose in poses]
        camera = self._camera([pose for pose, _ in shown])
        images = [self._draw(pose, camera, is_grey=is_grey) for pose, is_grey in shown]
        low, high = _content(images)
        gap = round(GAP * self.style.size)
        width = high[0] - low[0]
        whole = Image.new("RGBA", (len(images) * width + (len(images) - 1) * gap, high[1] - low[1]))
        for place, image in enumerate(images):
            whole.paste(image.crop((*low, *high)), (place * (width + gap), 0))
        return self._on_background(whole)

    def frames(self, count: int) -> Iterator[Image.Image]:
        """Square pictures in which all joints open and close once while the viewer swings from side to side.

        They have no background yet, and the margins that all of them need (see `trimmed`).
        """
        shares = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(count) / count)
        corners = self._corners([self.scene.opened(share) for share in (0.0, 0.5, 1.0)])
        whole = self._camera_at(corners, SIDE - SWING), self._camera_at(corners, SIDE), self._camera_at(corners, SIDE + SWING)
        focal = min(camera.focal for camera in whole)
        for place, share in enumerate(shares):
            camera = self._camera_at(corners, SIDE + SWING * math.sin(2.0 * math.pi * place / count))
            center = np.asarray(camera.center - 0.5 * camera.size) * focal / camera.focal + 0.5 * camera.size
            steady = Camera(camera.rotation, camera.middle, camera.radius, focal, center, camera.size)
            yield self._draw(self.scene.opened(float(share)), steady)

    def trimmed(self, frames: Sequence[Image.Image]) -> list[Image.Image]:
        """Frames on the background, without the margins that are empty in all of them."""
        low, high = _content(frames)
        return [self._on_background(frame.crop((*low, *high))) for frame in frames]

    @property
    def _diagonal(self) -> float:
        low, high = self.scene.bounds
        return float(np.linalg.norm(high - low))

    def _corners(self, poses: Sequence[Mapping[int, float]]) -> F64:
        """Points [N, 3] that the pictures have to show."""
        found = []
        for pose in poses:
            moved = self.scene.poses(pose)
            for index, leaf in self._owners:
                vertices = self.scene.meshes[leaf].corners
                found.append(vertices @ moved[index, :3, :3].T + moved[index, :3, 3])
            if self.style.has_axes:
                for index in self._moving:
                    above = moved[self._parent(index)]
                    found.append(self.scene.axis_ends(index) @ above[:3, :3].T + above[:3, 3])
        return np.concatenate(found)

    def _parent(self, index: int) -> int:
        parent = self.scene.bodies[index].parent
        assert parent is not None, "moving bodies have a parent"
        return parent

    def _camera(self, poses: Sequence[Mapping[int, float]]) -> Camera:
        return self._camera_at(self._corners(poses), SIDE)

    def _camera_at(self, corners: F64, side: float) -> Camera:
        return front_left(corners, UP, self.style.size, self.scene.front, side)

    def _draw(self, pose: Mapping[int, float], camera: Camera, *, is_grey: bool = False) -> Image.Image:
        moved = self.scene.poses(pose)
        own = moved[[index for index, _ in self._owners]]
        ranks = [index + 1 if index in self._moving else 0 for index, _ in self._owners]
        if self._looks is None or is_grey:
            seen = self._surfaces.render(camera, own, self._samples, ranks)
            colors = [(*(RESTING if is_grey else self.scene.bodies[index].color), 1.0) for index, _ in self._owners]
            image = lit(seen, np.array(colors)[seen.parts[seen.is_seen]], [index for index, _ in self._owners])
        else:
            image, seen = self._looks.draw(camera, own, self._samples, ranks)
        if self._moving and self.style.has_axes and not is_grey:
            above = moved[[self._parent(index) for index in self._moving]]
            tones = AXIS_SHADE * np.array([self.scene.bodies[index].color for index in self._moving])
            image = with_axes(image, seen, self._axes.render(camera, above, self._samples), tones)
        picture = Image.fromarray(pixels(image, self._samples))
        if not self.style.has_shadow:
            return picture
        below = Image.fromarray(shadow(self._surfaces, own, camera, float(self.scene.bounds[0] @ UP), UP))
        below.alpha_composite(picture)
        return below

    def _on_background(self, image: Image.Image) -> Image.Image:
        if self.style.background is None:
            return image
        whole = Image.new("RGBA", image.size, (*self.style.background, 255))
        whole.alpha_composite(image)
        return whole.convert("RGB")


def _content(images: Sequence[Image.Image]) -> tuple[tuple[int, int], tuple[int, int]]:
    """Corners of the smallest box that holds what is visible in all pictures, with a margin."""
    boxes = [box for image in images if (box := image.getchannel("A").point(lambda a: 255 * (a > 8)).getbbox())]
    width, height = images[0].size
    if not boxes:
        return (0, 0), (width, height)
    margin = round(0.02 * height)
    left, top = (max(min(box[side] for box in boxes) - margin, 0) for side in (0, 1))
    right = min(max(box[2] for box in boxes) + margin, width)
    bottom = min(max(box[3] for box in boxes) + margin, height)
    return (left, top), (right, bottom)


def _arrow(ends: F64, diagonal: float, sides: int = 20) -> Mesh:
    """An arrow between two points [2, 3]."""
    along = (ends[1] - ends[0]) / max(float(np.linalg.norm(ends[1] - ends[0])), np.finfo(float).tiny)
    first = np.cross(along, [1.0, 0.0, 0.0] if abs(along[0]) < 0.9 else [0.0, 1.0, 0.0])
    first /= np.linalg.norm(first)
    turn = 2.0 * np.pi * np.arange(sides) / sides
    ring = np.cos(turn)[:, None] * first + np.sin(turn)[:, None] * np.cross(along, first)
    neck = ends[1] - HEAD_LENGTH * diagonal * along
    tube = _tube(ends[0] + AXIS_RADIUS * diagonal * ring, neck + AXIS_RADIUS * diagonal * ring)
    base = neck + HEAD_RADIUS * diagonal * ring
    tip = np.broadcast_to(ends[1], ring.shape)
    return join(tube, _tube(base, tip), _tube(np.broadcast_to(neck, ring.shape), base))


def _tube(begin: F64, end: F64) -> Mesh:
    """The surface between two rings [N, 3]."""
    here = np.arange(len(begin))
    after = np.roll(here, -1)
    top, top_after = here + len(begin), after + len(begin)
    faces = np.concatenate([np.stack([here, after, top], 1), np.stack([top, after, top_after], 1)])
    return Mesh(np.concatenate([begin, end]), faces.astype(np.uint32))
