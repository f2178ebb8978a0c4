"""The command `kinmo predict`."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

from typer import Argument, BadParameter, Option

from kinmo.cli.execute import execute
from kinmo.cli.options import AxisName, Cluster, CollisionName, CommonOptions, MethodName, names_in, refuse

SCANS = "Options for scans"


def predict(
    options: CommonOptions,
    shapes: Annotated[
        list[Path],
        Argument(
            metavar="SHAPE",
            help="Shapes (files or folders), or folders with shapes anywhere below them. Or a scan, or a folder of scans.",
            show_default=False,
            readable=False,  # one that cannot be read is skipped, and stops no other
        ),
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
    category: Annotated[
        str | None, Option(help="Category of the object, in any spelling. Scans need it.", show_default="unknown")
    ] = None,
    up: Annotated[
        AxisName | None, Option(help="Axis of the shape's file that points up.", show_default="by file or format")
    ] = None,
    front: Annotated[
        AxisName | None, Option(help="Axis of the shape's file that points to the viewer.", show_default="z, or -y for --up z")
    ] = None,
    metres_per_unit: Annotated[
        float | None,
        Option(
            min=1e-9,
            max=1e9,
            help="Length of a unit of the shape's file in metres; 0.001 for millimetres.",
            show_default="by file, format or size",
        ),
    ] = None,
    labels: Annotated[
        Path | None,
        Option(help=".npy file with one integer per triangle of the shape: the number of its part.", show_default=False),
    ] = None,
    formats: Annotated[
        str,
        Option(
            "--format",
            "--formats",
            metavar="NAMES",
            help="Formats beside joints.json, with commas between: urdf, mjcf, usd, glb, partnet_mobility.",
        ),
    ] = "urdf",
    collision: Annotated[CollisionName, Option(help="How parts collide in a simulator.")] = "convex",
    cluster: Cluster = None,
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

    A shape is a 3D file (.glb, .gltf, .obj, .ply, .stl, .dae, .3mf, .usd), a robot (.urdf, MJCF .xml) or a folder
    (docs/reference/formats.md). Its nodes are the parts; a single mesh is split into loose pieces and at creases. Each shape
    gets a folder with joints.json (every joint with its score and alternatives) and a URDF with its meshes. Shapes that cannot
    be read are skipped; the exit code is then 1.

    A scan shows one object of a --category that kinmo train ancsh was run for (docs/guide/scans.md). It is an .npz or .npy file
    with points or depths, a .ply file, or a depth image (.png, .tif). The result has parts, boxes, poses, joints and joint
    states in the camera's frame, the part of every point, and a picture. With --category, a folder without
    shapes is a folder of scans.

    For example:

        kinmo predict my_shapes/cabinet -o out/
        kinmo predict my_shapes/ -o out/ --json > out.json
        kinmo predict cabinet.glb desk.obj -o out/
        kinmo predict cabinet.stl --category StorageFurniture --up z --front -y --metres-per-unit 0.001
        kinmo predict generated.glb --labels faces.npy
        kinmo predict scan.npz --category refrigerator
        kinmo predict scans/ --category refrigerator -o out/
        kinmo predict depth.png --category refrigerator --intrinsics 525,525,319.5,239.5 --depth-scale 1000 -o out/
    """
    if up is not None and front is not None and up[-1] == front[-1]:
        raise BadParameter(f"must be perpendicular to --up, got --up {up} --front {front}", param_hint="--front")
    from kinmo.dataset.workspace import Workspace

    workspace = Workspace(options.workspace)
    of_scans = {"--intrinsics": intrinsics, "--depth-scale": depth_scale}
    has_camera = any(value is not None for value in of_scans.values())
    # scans beside shapes are skipped as other files that are no shapes
    if all(_has_scans(path, category is not None, has_camera) for path in shapes):
        scan, *others = shapes
        of_shapes = {"--up": up, "--front": front, "--metres-per-unit": metres_per_unit, "--labels": labels}
        refuse({**of_shapes, "--cluster": cluster}, "applies only to shapes; remove it, or name a shape")
        if category is None:
            problem = f"a scan such as {scan} needs --category, the category of the object in it; a shape needs faces"
            raise BadParameter(problem, param_hint="--category")
        if others:
            raise BadParameter("expected one scan, or one folder of scans", param_hint="SHAPE...")
        from kinmo.pipeline.scans.predict_scans import PredictScans
        from kinmo.scans.files.camera_intrinsics import Intrinsics

        scans = PredictScans(
            scan,
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
    refuse(of_scans, "applies only to scans; give --category too, and name a scan")
    from kinmo.io.readers.stated_facts import StatedFacts
    from kinmo.pipeline.predict_shapes import PredictShapes

    stage = PredictShapes(
        shapes,
        out,
        workspace,
        method=method or "kinmo",
        seed=options.seed,
        device=options.device,
        workers=options.worker_count,
        facts=StatedFacts(category, up, front, metres_per_unit, labels),
        cluster=cluster,
        formats=names_in(formats),
        collision=collision,
    )
    execute(options, stage)


def _has_scans(path: Path, has_category: bool, has_camera: bool) -> bool:
    """True for a scan that can be read. With a category also for a folder that has no shapes, or whose camera is given."""
    from kinmo.io.readers.ply_reader import has_faces
    from kinmo.scans.files.scan_formats import SCAN_SUFFIXES

    try:
        is_there, is_file = path.exists(), path.is_file()
    except PermissionError:  # the search for shapes names it
        return False
    if is_file or not is_there:
        suffix = path.suffix.lower()
        is_mesh = suffix == ".ply" and is_file and has_faces(path)
        return suffix in SCAN_SUFFIXES and not is_mesh and (not is_there or os.access(path, os.R_OK))
    if not has_category:
        return False
    from kinmo.io.discover import discover

    return has_camera or next(discover(path), None) is None
