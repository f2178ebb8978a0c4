"""The stage `render-preview`: a picture or an animation of one object."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from kinmo.core.errors import InputError
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.io.atomic_files import write_bytes_atomically
from kinmo.view.object_scene import ObjectScene
from kinmo.view.opened_item import open_one
from kinmo.view.preview_pictures import Preview, PreviewColors, PreviewStyle

GIF, PNG = ".gif", ".png"
"""Endings of animations and of pictures."""
FRAMES = 40
"""Frames of an animation."""
FRAME_TIME = 80
"""Time of a frame in milliseconds."""
GIF_SAMPLES = 2
"""Samples along each side of a pixel in an animation."""
SECONDS_PER_PICTURE = 1.0


@dataclass(frozen=True)
class RenderPreview:
    """Draw an object at rest and with open joints, or as an animation if the file is a .gif."""

    path: Path
    out: Path
    source: Path | None = None
    size: int = 480
    poses: int = 3
    opening: float = 0.8  # share of the range of the joints in the last pose
    begins_grey: bool = False  # True to begin with the object in grey, as it was before the prediction
    has_axes: bool = True
    is_transparent: bool = False
    colors: PreviewColors = "auto"

    def plan(self) -> Plan:
        """Read the object."""
        self._check()
        open_one(self.path, self.source)
        count = FRAMES if self._is_animation else self.poses + self.begins_grey
        return Plan((f"write {self.out}",), count * SECONDS_PER_PICTURE)

    def run(self, observer: Observer) -> Outcome:
        """Write the file."""
        self._check()
        opened = open_one(self.path, self.source)
        opened.note_repairs(observer)
        scene = opened.scene()
        data = self._animation(scene, observer) if self._is_animation else self._picture(scene, observer)
        self.out.parent.mkdir(parents=True, exist_ok=True)
        write_bytes_atomically(self.out, data)
        return Outcome(self.out, {"preview": str(self.out), "object": scene.name})

    @property
    def _is_animation(self) -> bool:
        return self.out.suffix.lower() == GIF

    def _check(self) -> None:
        if self.out.suffix.lower() not in (GIF, PNG):
            raise InputError(self.out, "expected a name that ends in .png, or in .gif for an animation")
        if self.out.is_dir():
            raise InputError(self.out, "is a folder: name a file, such as preview.png")
        if self._is_animation and (self.is_transparent or self.begins_grey):
            option = "--transparent" if self.is_transparent else "--before"
            raise InputError(option, "applies only to a .png")

    def _picture(self, scene: ObjectScene, observer: Observer) -> bytes:
        background = None if self.is_transparent else (255, 255, 255)
        style = PreviewStyle(self.size, self.has_axes, colors=self.colors, background=background)
        shares = [0.0] if self.poses == 1 and not self.begins_grey else np.linspace(0.0, self.opening, self.poses)
        if self.poses == 1 and self.begins_grey:
            shares = [self.opening]
        preview = Preview(scene, style, observer.note)
        image = preview.strip([scene.opened(float(share)) for share in shares], begins_grey=self.begins_grey)
        buffer = io.BytesIO()
        image.save(buffer, format="png", optimize=True)
        return buffer.getvalue()

    def _animation(self, scene: ObjectScene, observer: Observer) -> bytes:
        style = PreviewStyle(self.size, self.has_axes, samples=GIF_SAMPLES, colors=self.colors)
        preview = Preview(scene, style, observer.note)
        drawn = []
        for done, frame in enumerate(preview.frames(FRAMES), 1):
            drawn.append(frame)
            observer.progress("drawing", done, FRAMES)
        frames = preview.trimmed(drawn)
        # one palette for all frames, so that colours do not flicker
        palette = frames[len(frames) // 2].quantize(255)
        first, *others = (frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames)
        buffer = io.BytesIO()
        first.save(buffer, format="gif", save_all=True, append_images=others, duration=FRAME_TIME, loop=0, optimize=True)
        return buffer.getvalue()
