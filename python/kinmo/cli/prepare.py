"""The command `kinmo prepare`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from kinmo.cli.execute import execute
from kinmo.cli.options import Cluster, CommonOptions


def prepare(
    options: CommonOptions,
    folder: Annotated[Path, Argument(help="Folder with shapes anywhere below it.", show_default=False)],
    oracle: Annotated[
        list[Path] | None,
        Option(help="Folder whose labels only test and compare; nothing is trained on them. Repeatable.", show_default=False),
    ] = None,
    cluster: Cluster = None,
) -> None:
    """Find, check and convert every shape below a folder.

    kinmo recognises PartNet-Mobility, PartNet and DSG-Net by their contents, and reads 3D files and robots as kinmo predict
    does. Unpack them anywhere below one folder. Small faults are repaired; unusable shapes are skipped. The table at the end
    counts both, and prepared/report.json and --json list every shape. Unchanged shapes are not prepared again.

    For example:

        kinmo prepare partnet/
        kinmo prepare partnet/ --oracle partnet/oracle
        kinmo prepare partnet/ --json > prepared.json
    """
    from kinmo.dataset.workspace import Workspace
    from kinmo.pipeline.prepare_shapes import Prepare

    workspace, count = Workspace(options.workspace), options.worker_count
    execute(options, Prepare(folder, workspace, count, options.seed, tuple(oracle or ()), cluster))
