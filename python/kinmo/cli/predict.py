"""kinmo predict."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from typer import Argument, BadParameter, Option

from kinmo.cli.execute import execute
from kinmo.cli.options import CommonOptions, Method
from kinmo.core.errors import InputError

SCANS = "Options for scans"
SMALLEST = 1e-9
"""Of what lengths may be multiplied or divided by."""


def predict(
    options: CommonOptions,
    shape: Annotated[
        Path,
        Argument(help="A shape's folder or .glb, a scan's file, or a folder with such anywhere below it.", show_default=False),
    ],
    out: Annotated[Path, Option("--out", "-o", help="Folder for the results, one folder a shape.")] = Path("predicted"),
    method: Annotated[
        Method | None,
        Option(
            help="Which method answers; for a scan, whose pseudo labels networks saw.",
            show_default="kinmo; for a scan, of whatever is trained",
        ),
    ] = None,
    up: Annotated[
        Literal["y", "z"] | None,
        Option(help="Which axis of a shape's own frame points up (z: with the front at -y).", show_default="y"),
    ] = None,
    metres_per_unit: Annotated[
        float | None,
        Option(
            min=SMALLEST,
            max=1.0 / SMALLEST,
            help="Metres that a unit of a shape's file is in its URDF; 0.001 for millimetres.",
            show_default="1",
        ),
    ] = None,
    category: Annotated[
        str | None, Option(help="What is seen in the scans, however it is spelled.", show_default=False, rich_help_panel=SCANS)
    ] = None,
    intrinsics: Annotated[
        str | None,
        Option(
            metavar="FX,FY,CX,CY",
            help="Of the camera, in pixels: for a depth image.",
            show_default=False,
            rich_help_panel=SCANS,
        ),
    ] = None,
    depth_scale: Annotated[
        float | None,
        Option(
            min=SMALLEST,
            max=1.0 / SMALLEST,
            help="Depths are divided by it; 1000 for millimetres.",
            show_default="1",
            rich_help_panel=SCANS,
        ),
    ] = None,
) -> None:
    """Predict the joints of your own shapes, or of what a depth scan shows.

    A shape is a hierarchy of named parts with meshes, or a .glb whose nodes are parts (docs/own-shapes.md). Each gets a folder
    with joints.json (every joint with its score and the alternatives that lost) and a URDF with its meshes. A shape that cannot
    be read is reported, the others go on, and the exit code is 1.

    A scan is an .npz or .npy file with points or depths, a .ply, or a depth image (.png, .tif), of one object of a --category
    that kinmo train ancsh knows (docs/scans.md). It gives a JSON file with parts, boxes, poses, joints and their states in the
    camera's frame, the part of every point, and a picture. With a --category, a folder is one of scans.

    For example:

        kinmo predict my_shapes/cabinet -o out/
        kinmo predict my_shapes/ -o out/ --json > out.json
        kinmo predict cabinet.glb -o out/
        kinmo predict blender_exports/ --up z -o out/
        kinmo predict scan.npz --category refrigerator
        kinmo predict scans/ --category refrigerator -o out/
        kinmo predict depth.png --category refrigerator --intrinsics 525,525,319.5,239.5 --depth-scale 1000 -o out/
    """
    from kinmo.dataset.workspace import Workspace
    from kinmo.scans.scan_reader import ENDINGS as SCAN_ENDINGS

    workspace = Workspace(options.workspace)
    if category is not None:
        for option, value in (("--up", up), ("--metres-per-unit", metres_per_unit)):
            if value is not None:
                raise InputError(option, "applies only to shapes; leave --category out")
        from kinmo.pipeline.scans.predict_scans import PredictScans
        from kinmo.scans.scan_reader import Intrinsics

        camera = None if intrinsics is None else Intrinsics.parse(intrinsics)
        answering = None if method is None else method.value
        scans = PredictScans(shape, out, workspace, category, camera, depth_scale, answering, options.seed, options.device)
        execute(options, scans)
        return
    if shape.is_file() and shape.suffix.lower() in SCAN_ENDINGS:
        raise BadParameter("a scan needs --category: what is to be seen in it", param_hint="--category")
    for name, of_scans in (("--intrinsics", intrinsics), ("--depth-scale", depth_scale)):
        if of_scans is not None:
            raise InputError(name, "applies only to scans; give --category too")
    from kinmo.pipeline.predict_shapes import Predict

    by = (method or Method.KINMO).value
    how = (by, options.seed, options.device, options.worker_count, up or "y", metres_per_unit or 1.0)
    execute(options, Predict(shape, out, workspace, *how))
