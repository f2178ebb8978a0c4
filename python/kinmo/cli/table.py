"""kinmo table."""

from __future__ import annotations

from enum import Enum
from typing import Annotated

from typer import Argument, Option

from kinmo.cli.execute import execute
from kinmo.cli.options import CommonOptions, Method, ProtocolName, Start
from kinmo.core.errors import InputError


class Name(str, Enum):
    """The tables of `kinmo.experiments.scan_tables.make_table`, without importing it."""

    SETTINGS = "2"
    RATIOS = "3"
    DSG_NET = "4"
    SENSORS = "sensors"


def table(
    options: CommonOptions,
    name: Annotated[Name, Argument(help="Which of the paper's tables, or sensors.", show_default=False)],
    config: Annotated[str, Option("--config", "-c", help="small (a CPU), paper (a GPU), or a TOML file.")] = "small",
    category: Annotated[
        str | None, Option(help="Only this category.", show_default="those of the paper that are there")
    ] = None,
    start: Start = None,
    seeds: Annotated[
        int | None, Option(min=1, max=100, help="How often every cell is trained.", show_default="3 or 1, by category")
    ] = None,
    hours: Annotated[float | None, Option(min=0.0, help="Begin nothing that would end later.", show_default=False)] = None,
    method: Annotated[
        Method | None, Option(help="Only rows with pseudo labels of this method.", show_default="all; with --from, kinmo")
    ] = None,
    protocol: Annotated[
        ProtocolName, Option(help="How scans are measured: rightly, or as ANCSH's public code does, faults included.")
    ] = ProtocolName.KINMO,
) -> None:
    """Train and judge all that one of the paper's tables of partial scans is about.

    2 compares networks that see labelled shapes alone (supervised), their own labels of unlabelled scans too (semi), pseudo
    labels of unlabelled shapes (semi-weakly; by kinmo's method and by the paper's), and true ones. 3 has fewer labels: 100, 80,
    50 and 30 %. 4 takes shapes in the layout of DSG-Net for the unlabelled ones. sensors, none of the paper's, tells what a bad
    depth camera costs, and what is gained by training for it, without and with pseudo labels. Cells are done one after the
    other and kept: the same command goes on where it stopped, and what was not run is shown as such.

    For example:

        kinmo table 2 --category refrigerator
        kinmo table 3 --hours 4
        kinmo table 2 --category laptop --from many
    """
    from kinmo.dataset.workspace import Workspace
    from kinmo.experiments.scan_tables.make_table import MakeTable

    if name is Name.SENSORS and method is Method.PAPER:
        raise InputError("--method", "sensors has no rows with pseudo labels of paper")
    if start is not None:  # which networks of the paper's method cannot
        if method is Method.PAPER:
            raise InputError("--from", "paper cannot start from trained weights; use it with kinmo")
        method = Method.KINMO
    methods = tuple(each.value for each in Method) if method is None else (method.value,)
    stage = MakeTable(
        name.value,
        Workspace(options.workspace),
        config,
        methods,
        category,
        seeds,
        hours,
        protocol.value,
        options.seed,
        options.device,
        options.worker_count,
        None if start is None else Workspace(start),
    )
    execute(options, stage)
