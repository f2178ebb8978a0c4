"""The command `kinmo table`."""

from __future__ import annotations

from typing import Annotated, Literal, get_args

from typer import Argument, Option

from kinmo.cli.execute import execute
from kinmo.cli.options import CommonOptions, Config, Details, MethodName, ProtocolName, Start
from kinmo.core.errors import InputError

TableName = Literal["2", "3", "4", "sensors"]
"""Tables of `kinmo.experiments.scan_tables`."""


def table(
    options: CommonOptions,
    name: Annotated[TableName, Argument(help="Table of the paper, or sensors.", show_default=False)],
    config: Config = "small",
    category: Annotated[str | None, Option(help="Only this category.", show_default="the table's own")] = None,
    start: Start = None,
    seeds: Annotated[
        int | None, Option(min=1, max=100, help="Number of trainings of each row.", show_default="3 or 1, by category")
    ] = None,
    hours: Annotated[float | None, Option(min=0.0, help="Begin nothing that would end later.", show_default=False)] = None,
    method: Annotated[
        MethodName | None,
        Option(help="Only rows with pseudo labels of this method.", show_default="all; with --from, kinmo"),
    ] = None,
    protocol: Annotated[
        ProtocolName, Option(help="Errors as kinmo defines them, or as ANCSH's public code computes them.")
    ] = "kinmo",
    details: Details = False,
) -> None:
    """Train and evaluate everything for one of the paper's tables of partial scans.

    The tables are:

        2         supervised, self-training, semi-weakly supervised (by both methods), and oracle labels
        3         fewer labels: 100, 80, 50 and 30 %
        4         generated shapes, in DSG-Net's layout, as the unlabelled ones
        sensors   cost of a noisy depth camera, and gain of training for it (not in the paper)

    Rows are done one after the other and kept. The same command continues an interrupted run.

    For example:

        kinmo table 2 --category refrigerator
        kinmo table 3 --hours 4
        kinmo table 2 --category laptop --from many
    """
    from kinmo.api.stages import start_workspace
    from kinmo.dataset.workspace import Workspace
    from kinmo.experiments.scan_tables.make_table import MakeTable

    if name == "sensors" and method == "paper":
        raise InputError("--method", "sensors has no rows with pseudo labels of paper")
    if start is not None:  # networks of the paper's method cannot continue
        if method == "paper":
            raise InputError("--from", "paper cannot start from trained weights; use it with kinmo")
        method = "kinmo"
    stage = MakeTable(
        name,
        Workspace(options.workspace),
        config,
        methods=get_args(MethodName) if method is None else (method,),
        category=category,
        seeds=seeds,
        hours=hours,
        protocol=protocol,
        seed=options.seed,
        device=options.device,
        workers=options.worker_count,
        start=start_workspace(start),
        details=details,
    )
    execute(options, stage)
