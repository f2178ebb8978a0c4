"""The command `kinmo render`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Option

from kinmo.cli.execute import execute
from kinmo.cli.options import Cluster, CommonOptions, MethodName
from kinmo.core.errors import InputError


def render(
    options: CommonOptions,
    config: Annotated[str, Option("--config", "-c", help="small, paper, or a TOML file with a table scans.")] = "small",
    category: Annotated[str | None, Option(help="Only shapes of this category.", show_default="the paper's five")] = None,
    example: Annotated[
        Path | None,
        Option(help="Write one test scan to this .npz file, to try kinmo predict on.", show_default=False),
    ] = None,
    method: Annotated[MethodName, Option(help="Method whose pseudo labels are used.")] = "kinmo",
    unlabelled: Annotated[bool, Option("--unlabelled", help="Scan shapes without joints too, as they stand.")] = False,
    cluster: Cluster = None,
) -> None:
    """Scan shapes with a virtual depth camera.

    Shapes with joints, or with pseudo labels, are scanned in many joint states from many views. Each frame has 1024 points with
    their parts and their positions on them. Small parts count as one with the part that they move against. Frames that show too
    little of a part are skipped and counted. Only shapes with the joints of most training shapes are scanned. A TOML file can
    add sensor noise, holes, crops and a floor.

    For example:

        kinmo render
        kinmo render --category laptop
        kinmo render --category laptop --example scan.npz
    """
    from kinmo.dataset.workspace import Workspace
    from kinmo.pipeline.scans.example_scan import ExampleScan
    from kinmo.pipeline.scans.render_scans import WITH_LABELS, RenderScans

    workspace = Workspace(options.workspace)
    rendering = RenderScans(
        workspace,
        config,
        category,
        seed=options.seed,
        workers=options.worker_count,
        extra=(*WITH_LABELS, "unlabelled") if unlabelled else WITH_LABELS,
        method=method,
        cluster=cluster,
    )
    if example is None:
        execute(options, rendering)
    elif category is None:
        raise InputError("--example", "expected --category too: the category of the scan")
    else:
        execute(options, ExampleScan(workspace, category, example, rendering, options.seed))
