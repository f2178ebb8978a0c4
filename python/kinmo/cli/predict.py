"""The command `kinmo predict`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from typer import Argument, BadParameter, Option

from kinmo.cli.execute import execute
from kinmo.cli.options import Cluster, CommonOptions, MethodName, refuse

SCANS = "Options for scans"


def predict(
    options: CommonOptions,
    shape: Annotated[
        Path,
        Argument(help="A shape (folder or .glb), a scan, or a folder with such anywhere below it.", show_default=False),
    ],
    out: Annotated[Path, Option("--out", "-o", help="Folder for the results; each shape gets a folder in it.")] = Path(
        "predicted"
    ),
    method: Annotated[
        MethodName | None,
        Option(
            help="Method; for scans, the method whose pseudo labels the networks learned from.",
            show_default="kinmo; for scans, the best trained",
        ),
    ] = None,
    up: Annotated[
        Literal["y", "z"] | None,
        Option(help="Axis of the shape's frame that points up (z: with the front at -y).", show_default="y"),
    ] = None,
    metres_per_unit: Annotated[
        float | None,
        Option(
            min=1e-9, max=1e9, help="Length of a unit of the shape's file in metres; 0.001 for millimetres.", show_default="1"
        ),
    ] = None,
    cluster: Cluster = None,
    category: Annotated[
        str | None,
        Option(help="Category of the object in the scans, in any spelling.", show_default=False, rich_help_panel=SCANS),
    ] = None,
    intrinsics: Annotated[
        str | None,
        Option(metavar="FX,FY,CX,CY", help="Camera of depth images, in pixels.", show_default=False, rich_help_panel=SCANS),
    ] = None,
    depth_scale: Annotated[
        float | None,
        Option(
            min=1e-9,
            max=1e9,
            help="Number that depths are divided by; 1000 for millimetres.",
            show_default="1",
            rich_help_panel=SCANS,
        ),
    ] = None,
) -> None:
    """Predict the joints of your own shapes, or of the object in a depth scan.

    A shape is a hierarchy of named parts with meshes, or a .glb whose nodes are parts (docs/guide/predict.md). Each shape gets
    a folder with joints.json (every joint with its score and alternatives) and a URDF with its meshes. Shapes that cannot be
    read are skipped; the exit code is then 1.

    A scan shows one object of a --category that kinmo train ancsh was run for (docs/guide/scans.md). It is an .npz or .npy file
    with points or depths, a .ply file, or a depth image (.png, .tif). The result has parts, boxes, poses, joints and joint
    states in the camera's frame, the part of every point, and a picture. With --category, a folder is a folder of scans.

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
    from kinmo.scans.files.scan_formats import SCAN_SUFFIXES

    workspace = Workspace(options.workspace)
    if category is not None:
        only_shapes = {"--up": up, "--metres-per-unit": metres_per_unit, "--cluster": cluster}
        refuse(only_shapes, "applies only to shapes; remove it, or remove --category")
        if shape.is_file() and shape.suffix.lower() not in SCAN_SUFFIXES:
            raise BadParameter(
                f"{shape} is no scan ({', '.join(SCAN_SUFFIXES)}); for a shape leave it out", param_hint="--category"
            )
        from kinmo.pipeline.scans.predict_scans import PredictScans
        from kinmo.scans.files.camera_intrinsics import Intrinsics

        scans = PredictScans(
            shape,
            out,
            workspace,
            category,
            intrinsics=None if intrinsics is None else Intrinsics.parse(intrinsics),
            depth_scale=depth_scale,
            method=method,
            seed=options.seed,
            device=options.device,
        )
        execute(options, scans)
        return
    if shape.is_file() and shape.suffix.lower() in SCAN_SUFFIXES:
        raise BadParameter("a scan needs --category, the category of the object in it", param_hint="--category")
    refuse({"--intrinsics": intrinsics, "--depth-scale": depth_scale}, "applies only to scans; give --category too")
    from kinmo.pipeline.predict_shapes import PredictShapes

    shapes = PredictShapes(
        shape,
        out,
        workspace,
        method=method or "kinmo",
        seed=options.seed,
        device=options.device,
        workers=options.worker_count,
        up=up or "y",
        metres_per_unit=metres_per_unit or 1.0,
        cluster=cluster,
    )
    execute(options, shapes)
