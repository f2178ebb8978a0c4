"""kinmo render."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Option

from kinmo.cli.execute import execute
from kinmo.cli.options import CommonOptions, Method
from kinmo.core.errors import InputError


def render(
    options: CommonOptions,
    config: Annotated[str, Option("--config", "-c", help="small, paper, or a TOML file with a table scans.")] = "small",
    category: Annotated[
        str | None, Option(help="Only shapes of this category.", show_default="those of the paper that are there")
    ] = None,
    example: Annotated[
        Path | None,
        Option(
            help="Write a scan of a test object, which is made if there is none, to this .npz, to try kinmo predict on.",
            show_default=False,
        ),
    ] = None,
    method: Annotated[Method, Option(help="Whose pseudo labels to go by.")] = Method.KINMO,
    unlabelled: Annotated[bool, Option("--unlabelled", help="Scan shapes without joints too, as they stand.")] = False,
) -> None:
    """Scan shapes with a virtual depth camera.

    Every shape with joints, or with pseudo labels, is seen in many states from many sides; each frame is 1024 points with the
    part that every one is of and where on it. What is too small to be seen goes with what it moves against, and frames that
    show too little of a part are refused and counted. Shapes with other joints than most of those to train on are counted too,
    and not scanned unless they are among these: no network would see them. Sensor noise, holes, crops and a floor can be asked
    for in a TOML file.

    For example:

        kinmo render
        kinmo render --category laptop
        kinmo render --category laptop --example scan.npz
    """
    from kinmo.dataset.workspace import Workspace
    from kinmo.pipeline.scans.example_scan import ExampleScan
    from kinmo.pipeline.scans.render_scans import WITH_LABELS, Render

    beside = (*WITH_LABELS, "unlabelled") if unlabelled else WITH_LABELS
    workspace = Workspace(options.workspace, method=method.value)
    rendering = Render(workspace, config, category, options.seed, options.worker_count, beside)
    if example is None:
        execute(options, rendering)
    elif category is None:
        raise InputError("--example", "expected --category too, which it is to be of")
    else:
        execute(options, ExampleScan(workspace, category, example, rendering, options.seed))
