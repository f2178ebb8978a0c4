"""kinmo prepare."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from kinmo.cli.execute import execute
from kinmo.cli.options import CommonOptions


def prepare(
    options: CommonOptions,
    folder: Annotated[Path, Argument(help="Folder with shapes anywhere below it.", show_default=False)],
    hold_back: Annotated[
        list[Path] | None,
        Option(help="Folder whose labels are for tests and comparison alone; may be repeated.", show_default=False),
    ] = None,
) -> None:
    """Find, check and convert every shape below a folder.

    PartNet-Mobility, PartNet and DSG-Net are told apart by what the folders contain, so unpack them anywhere below one folder;
    files of binary glTF (.glb) are shapes without labels.
    What can be mended is mended, what cannot be used is left out: the table at the end counts repairs and lists what was left
    out, and prepared/report.json, and --json, have every shape. Shapes that have not changed since the last time are not
    prepared again.

    For example:

        kinmo prepare partnet/
        kinmo prepare partnet/ --hold-back partnet/held_back
        kinmo prepare partnet/ --json > what_was_wrong.json
    """
    from kinmo.dataset.workspace import Workspace
    from kinmo.pipeline.prepare import Prepare

    execute(options, Prepare(folder, Workspace(options.workspace), options.worker_count, options.seed, tuple(hold_back or ())))
