"""The command `kinmo export`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from kinmo.cli.execute import execute
from kinmo.cli.options import CollisionName, CommonOptions, names_in


def export(
    options: CommonOptions,
    results: Annotated[
        Path, Argument(help="A result of kinmo predict (folder with joints.json), or a folder of results.", show_default=False)
    ],
    formats: Annotated[
        str | None,
        Option(
            "--format",
            "--formats",
            metavar="NAMES",
            help="Formats with commas between: urdf, mjcf, usd, glb, joints_json, partnet_mobility.",
            show_default="those that are there",
        ),
    ] = None,
    collision: Annotated[
        CollisionName | None, Option(help="How parts collide in a simulator.", show_default="as before")
    ] = None,
    package: Annotated[
        str | None,
        Option(
            metavar="NAME", help='ROS package in the paths of URDFs: package://NAME/.... "" for none.', show_default="as before"
        ),
    ] = None,
    out: Annotated[
        Path | None,
        Option("--out", "-o", help="Folder for the exports; each result gets a folder in it.", show_default="in place"),
    ] = None,
    source: Annotated[
        Path | None, Option(help="File or folder of the shape, if it is in another place than before.", show_default=False)
    ] = None,
) -> None:
    """Correct predictions by hand, and export them again without predicting.

    Write corrections into overrides.toml, beside joints.json: type, axis, origin, range, parent, parts or name of any body
    (docs/guide/correct.md). kinmo export applies them, each time to the joints as predicted, and writes the files of the result
    again. Without overrides.toml the files are those of kinmo predict. No network is needed.

    With --format partnet_mobility, corrected objects become training data for kinmo prepare.

    For example:

        kinmo export out/cabinet
        kinmo export out/ --dry-run
        kinmo export out/cabinet --format urdf,mjcf -o robots/
        kinmo export out/cabinet --format urdf --package cabinet_description -o ros/
        kinmo export out/ --format partnet_mobility -o my_data/
    """
    from kinmo.pipeline.export_results import ExportResults

    execute(options, ExportResults(results, names_in(formats or ""), out, source, options.worker_count, collision, package))
