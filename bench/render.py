"""Depth pictures of parts, one thread: kinmo's z-buffer against PyBullet's TinyRenderer; and whole labelled frames.

    RAYON_NUM_THREADS=1 OMP_NUM_THREADS=1 python bench/render.py [--quick]

Boxes, and cupboards of boxes whose faces are divided until they have 50,000 and 300,000 triangles, at 512 x 512 pixels, shadows
off. First checks that both see the same: equal parts in 99.9 % of the pixels, depths to 1e-4 of the camera's range.
"""

from __future__ import annotations

import os

for variable in ("RAYON_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from kinmo.config import ScansConfig
from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body, Mobility
from kinmo.core.shape import Mesh
from kinmo.scans.canonical.articulated_object import ArticulatedObject
from kinmo.scans.files.scan_file import ScanProvenance, write_scans
from kinmo.scans.rendering.camera import Camera, Viewpoints
from kinmo.scans.rendering.labelled_frames import FAR, NEAR, scan_object
from kinmo.scans.rendering.renderers import NO_PART, PybulletRenderer, RasterRenderer, Renderer

F64 = NDArray[np.float64]
GOAL, FRAME_GOAL = 8.0, 10.0
UP = np.array([0.0, 0.0, 1.0])


def cupboard(triangles: int) -> ArticulatedObject:
    """A carcass, a door and a drawer with about so many triangles in all."""
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


def seconds(renderer: Renderer, poses: F64, camera: Camera, repeats: int) -> float:
    """Least processor time a picture of some runs."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        renderer.render(poses, camera)
        times.append((time.process_time() - start) / len(poses))
    return min(times)


def compare(name: str, target: ArticulatedObject, frames: int, repeats: int) -> None:
    """One line of figures, and one of JSON."""
    rng = np.random.default_rng(0)
    views = Viewpoints()
    camera = Camera.from_field_of_view(512, 512, views.field_of_view, NEAR, FAR)
    poses = np.stack([np.tile(views.sample(rng, np.zeros(3), 0.5, UP), (len(target.meshes), 1, 1)) for _ in range(frames)])
    with RasterRenderer(target.meshes) as ours, PybulletRenderer(target.meshes, both_sides=False) as theirs:
        mine, reference = ours.render(poses, camera), theirs.render(poses, camera)
        same = mine.parts == reference.parts
        both = same & (mine.parts != NO_PART)
        off = float(np.abs(mine.depths - reference.depths)[both].max() / (FAR - NEAR))
        own, peer = seconds(ours, poses, camera, repeats), seconds(theirs, poses, camera, max(1, repeats // 2))
    agrees = bool(same.mean() >= 0.999 and off < 1e-4)
    print(f"{name}: {1 / own:.0f} frames/s, PyBullet {1 / peer:.1f}: {peer / own:.1f} times; equal parts {same.mean():.5f}, "
          f"depths off by {off:.1e} of the range")  # fmt: skip
    line = {"claim": f"pictures at 512 x 512, {name}", "ours": 1 / own, "peer": 1 / peer, "ratio": peer / own, "goal": GOAL}
    print(json.dumps(line | {"met": agrees and peer / own >= GOAL}))


def whole_frames(target: ArticulatedObject, quick: bool) -> None:
    """Drawing the state and the camera, the picture, and 1,024 labelled points; then with what a bad sensor makes of it.

    Then all of that with what it takes to write them, which is to find the axes that networks see them along; a frame without
    enough pixels of some part is drawn, and neither kept nor written.
    """
    config = ScansConfig(states=2 if quick else 10, views=10)
    for words, sensor, goal in (("", config.sensor, FRAME_GOAL), (", by a bad sensor", config.rough, None)):
        start = time.process_time()
        frames = scan_object(target, replace(config, sensor=sensor), 0)
        labelled = time.process_time()
        drawn = len(frames) + frames.skipped.total()
        tell(f"ms a labelled frame of 1,024 points{words}", labelled - start, drawn, goal)
        with TemporaryDirectory() as folder:
            write_scans(Path(folder) / "scans.safetensors", target, frames, ScanProvenance())
        written = time.process_time()
        kept = f"{len(frames)} of {drawn} kept"
        tell(f"ms with the axes that networks see it along, written ({kept}){words}", written - start, drawn, goal)
        tell(f"ms these axes and writing, of one that is kept{words}", written - labelled, len(frames), None)


def tell(claim: str, seconds: float, frames: int, goal: float | None) -> None:
    """A line of JSON: the time a frame."""
    each = 1e3 * seconds / frames
    line = {"claim": claim, "ours": each, "peer": None, "ratio": None, "goal": goal}
    print(json.dumps(line | {"met": None if goal is None else each <= goal}))


def main() -> None:
    """All sizes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="few pictures and repeats")
    quick = parser.parse_args().quick
    frames, repeats = (4, 1) if quick else (20, 6)
    for name, triangles in (("boxes", 36), ("50,000 triangles", 50_000), ("300,000 triangles", 300_000)):
        target = cupboard(triangles)
        count = sum(len(mesh.faces) for mesh in target.meshes)
        compare(f"{name} ({count:,})", target, frames, repeats)
        whole_frames(target, quick)


if __name__ == "__main__":
    main()
