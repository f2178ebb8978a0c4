"""The command `kinmo export`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from kinmo.cli.execute import execute
from kinmo.cli.options import CommonOptions


def export(
    options: CommonOptions,
    results: Annotated[
        Path, Argument(help="A result of kinmo predict (folder with joints.json), or a folder of results.", show_default=False)
    ],
    formats: Annotated[
        str | None,
        Option(
            metavar="NAMES", help="Formats with commas between: urdf, joints_json, ...", show_default="those that are there"
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

    With --formats partnet_mobility, corrected objects become training data for kinmo prepare.

    For example:

        kinmo export out/cabinet
        kinmo export out/ --dry-run
        kinmo export out/cabinet --formats urdf -o robots/
        kinmo export out/ --formats partnet_mobility -o my_data/
    """
    from kinmo.pipeline.export_results import ExportResults

    names = tuple(name.strip() for name in (formats or "").split(",") if name.strip())
    execute(options, ExportResults(results, names, out, source, options.worker_count))
