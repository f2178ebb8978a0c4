"""The command `kinmo check`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from kinmo.cli.execute import execute
from kinmo.cli.options import CommonOptions, names_in


def check(
    options: CommonOptions,
    results: Annotated[
        Path, Argument(help="A result of kinmo predict (folder with joints.json), or a folder of results.", show_default=False)
    ],
    simulator: Annotated[
        str | None,
        Option(
            "--simulator",
            metavar="NAMES",
            help="Simulators with commas between: mujoco (URDF, MJCF), pybullet (URDF), usd (USD).",
            show_default="those that are installed",
        ),
    ] = None,
    time_limit: Annotated[float, Option(min=1.0, help="Longest time for a result, in seconds.")] = 300.0,
) -> None:
    """Test if results work in simulators, and say why not.

    Each URDF, MJCF and USD file of a result is loaded by each simulator that reads it. It loads without a warning, stays at
    rest but for parts that gravity opens, moves through the range of every joint, and its links are where kinmo expects them.
    USD has no physics: the file is validated and its links are compared, but rests and moves are not tested
    (docs/guide/simulators.md).

    Prints a line for each object with the first problem, and the path. --json has all problems. The exit code is 1 if an object
    does not work. Nothing is written. A simulator that crashes or hangs fails that object alone.

    For example:

        kinmo check out/
        kinmo check out/cabinet --simulator mujoco
        kinmo check out/ --json > check.json
    """
    from kinmo.pipeline.check_results import CheckResults

    execute(options, CheckResults(results, names_in(simulator or ""), options.worker_count, time_limit))
