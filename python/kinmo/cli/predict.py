"""kinmo predict."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from kinmo.cli.execute import execute
from kinmo.cli.options import CommonOptions, Method


def predict(
    options: CommonOptions,
    shape: Annotated[Path, Argument(help="A shape's folder, or a folder with shapes anywhere below it.", show_default=False)],
    out: Annotated[Path, Option("--out", "-o", help="Folder for the results, one folder a shape.", show_default=False)],
    method: Annotated[Method, Option(help="Which method answers.")] = Method.KINMO,
) -> None:
    """Predict the joints of your own shapes.

    A shape is a hierarchy of named parts with meshes (docs/own-shapes.md). Each gets a folder with joints.json (every joint
    with its score and the alternatives that lost) and a URDF with its meshes. A shape that cannot be read is reported, the
    others go on, and the exit code is 1.

    For example:

        kinmo predict my_shapes/cabinet -o out/
        kinmo predict my_shapes/ -o out/ --json > out.json
    """
    from kinmo.pipeline.predict import Predict
    from kinmo.workspace import Workspace

    workspace = Workspace(options.workspace)
    execute(options, Predict(shape, out, workspace, method.value, options.seed, options.device, options.worker_count))
