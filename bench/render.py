"""Depth images and labelled scans, one thread: kinmo's renderer compared with PyBullet's TinyRenderer.

Boxes, and cupboards of boxes with 50,000 and 300,000 triangles, at 512 x 512 pixels without shadows. Both must see the same:
equal parts in 99.9 % of the pixels, and depths within 1e-4 of the camera's range. Whole frames of 1,024 labelled points are
timed for an ideal and a noisy sensor, with the search of their canonical axes and writing, and without.

Usage:
    python bench/render.py [--quick]
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from common import Claim, best_time, budget_claim, option_parser, print_claims, print_table, ratio_claim, use_one_thread

use_one_thread()

import numpy as np
from numpy.typing import NDArray

from kinmo.config import ScansConfig, SensorConfig
from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body, Mobility
from kinmo.core.shape import Mesh
from kinmo.scans.canonical.articulated_object import ArticulatedObject
from kinmo.scans.files.scan_file import ScanProvenance, write_scans
from kinmo.scans.rendering.labelled_frames import FAR, NEAR, scan_object
from kinmo.scans.rendering.pinhole_camera import Camera, Viewpoints
from kinmo.scans.rendering.renderers import NO_PART, PybulletRenderer, RasterRenderer

F64 = NDArray[np.float64]
GOAL = 8.0
"""Ratio to reach."""
FRAME_BUDGET = 10.0
"""Time of a frame that is written, in ms."""
UP = np.array([0.0, 0.0, 1.0])


def cupboard(triangles: int) -> ArticulatedObject:
    """A carcass, a door and a drawer with about `triangles` triangles in all."""
    boxes = [
        ((0.5, 0.5, 0.7), (0.0, 0.0, 0.0)),
        ((0.02, 0.25, 0.35), (-0.26, 0.12, 0.15)),
        ((0.2, 0.4, 0.2), (-0.2, 0.0, -0.2)),
    ]
    steps = max(1, round((triangles / 36) ** 0.5))
    meshes = [_divided_box(np.array(size), np.array(center), steps) for size, center in boxes]
    joints = [
        None,
        Joint(JointKind.REVOLUTE, UP, np.array([-0.26, 0.245, 0.0]), 0.0, 1.5),
        Joint(JointKind.PRISMATIC, np.array([-1.0, 0.0, 0.0]), np.zeros(3), 0.0, 0.3),
    ]
    bodies = [Body(i, f"part {i}", (i,), None if joint is None else 0, joint) for i, joint in enumerate(joints)]
    return ArticulatedObject("cupboard", "Cupboard", UP, Mobility(tuple(bodies)), tuple(meshes))


def _divided_box(size: F64, center: F64, steps: int) -> Mesh:
    """A box whose sides are grids of `steps` x `steps` cells of two triangles."""
    x, y = (axis.ravel() for axis in np.meshgrid(*[np.linspace(-0.5, 0.5, steps + 1)] * 2, indexing="ij"))
    corner = (np.arange(steps)[:, None] * (steps + 1) + np.arange(steps)).ravel()
    cells = np.stack([corner, corner + steps + 1, corner + steps + 2, corner + 1], axis=1)
    grid = np.concatenate([cells[:, [0, 1, 2]], cells[:, [0, 2, 3]]])
    vertices, faces = [], []
    for axis in range(3):
        for side in (-0.5, 0.5):
            is_outward = (side > 0.0) == (axis != 1)
            faces.append((grid if is_outward else grid[:, ::-1]) + len(vertices) * len(x))
            vertices.append(np.insert(np.stack([x, y], axis=1), axis, side, axis=1))
    return Mesh(np.concatenate(vertices) * size + center, np.concatenate(faces).astype(np.uint32))


@dataclass(frozen=True)
class Comparison:
    """Seconds an image of kinmo and PyBullet, and how well the images agree."""

    ours: float
    peer: float
    equal_parts: float
    depth_difference: float

    @property
    def agrees(self) -> bool:
        """True if the images are equal for the purpose of the claim."""
        return self.equal_parts >= 0.999 and self.depth_difference < 1e-4


def compare(target: ArticulatedObject, frames: int, repeats: int) -> Comparison:
    """Render an object from random views with both renderers."""
    rng = np.random.default_rng(0)
    views = Viewpoints()
    camera = Camera.from_field_of_view(512, 512, views.field_of_view, NEAR, FAR)
    poses = np.stack([np.tile(views.sample(rng, np.zeros(3), 0.5, UP), (len(target.meshes), 1, 1)) for _ in range(frames)])
    with RasterRenderer(target.meshes) as ours, PybulletRenderer(target.meshes, both_sides=False) as theirs:
        mine, reference = ours.render(poses, camera), theirs.render(poses, camera)
        same = mine.parts == reference.parts
        both = same & (mine.parts != NO_PART)
        off = float(np.abs(mine.depths - reference.depths)[both].max() / (FAR - NEAR))
        own = best_time(lambda: ours.render(poses, camera), repeats) / frames
        peer = best_time(lambda: theirs.render(poses, camera), max(1, repeats // 2)) / frames
    return Comparison(own, peer, float(same.mean()), off)


def frame_times(target: ArticulatedObject, sensor: SensorConfig, states: int) -> tuple[float, float, float]:
    """Times in ms: a labelled frame, a frame with its axes and written, and the second step alone of a frame that is kept.

    A frame with too few pixels of a part is drawn, but neither kept nor written.
    """
    config = replace(ScansConfig(states=states, views=10), sensor=sensor)
    start = time.process_time()
    frames = scan_object(target, config, 0)
    labelled = time.process_time()
    with TemporaryDirectory() as folder:
        write_scans(Path(folder) / "scans.safetensors", target, frames, ScanProvenance())
    written = time.process_time()
    drawn = len(frames) + frames.skipped.total()
    return 1e3 * (labelled - start) / drawn, 1e3 * (written - start) / drawn, 1e3 * (written - labelled) / len(frames)


def main() -> None:
    """Compare all sizes."""
    quick = option_parser(__doc__, "few images and repeats").parse_args().quick
    frames, repeats, states = (4, 1, 2) if quick else (20, 6, 10)
    claims: list[Claim] = []
    images, times = [], []
    for name, triangles in (("boxes", 36), ("50,000 triangles", 50_000), ("300,000 triangles", 300_000)):
        target = cupboard(triangles)
        found = compare(target, frames, repeats)
        ratio = found.peer / found.ours
        images.append((name, 1 / found.ours, 1 / found.peer, ratio, found.equal_parts, found.depth_difference))
        claim = f"images of 512 x 512 pixels, {name}, compared with PyBullet, s an image"
        claims.append(ratio_claim(claim, ours=found.ours, peer=found.peer, goal=GOAL, agree=found.agrees))
        for sensor_name, sensor in (("ideal", ScansConfig().sensor), ("noisy", ScansConfig().noisy_sensor)):
            labelled, written, rest = frame_times(target, sensor, states)
            times.append((name, sensor_name, labelled, written, rest))
            if sensor_name == "ideal":
                claims.append(budget_claim(f"a labelled frame of {name}, written, ms", written, FRAME_BUDGET))
    print_table(("object", "kinmo (images/s)", "PyBullet (images/s)", "ratio", "equal parts", "depth difference"), images)
    print()
    print_table(("object", "sensor", "labelled frame (ms)", "with axes, written (ms)", "axes and writing alone (ms)"), times)
    print_claims(*claims)


if __name__ == "__main__":
    main()
