"""kinmo train."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from kinmo.cli.execute import execute
from kinmo.cli.options import CommonOptions


class What(str, Enum):
    """The groups of `kinmo.pipeline.models`, without importing it."""

    GNN = "gnn"
    AXIS = "axis"
    ALL = "all"
    CONTACT_EDGES = "contact-edges"


def train(
    options: CommonOptions,
    what: Annotated[What, Argument(help="Which networks to train.", show_default=False)],
    config: Annotated[str, Option("--config", "-c", help="small (a CPU), paper (a GPU), or a TOML file.")] = "small",
    category: Annotated[
        str | None, Option(help="Only shapes of this category, however it is spelled.", show_default=False)
    ] = None,
    start: Annotated[
        Path | None, Option("--from", help="A workspace whose ranking networks to go on from.", show_default=False)
    ] = None,
) -> None:
    """Train the networks on the labelled shapes.

    gnn predicts how neighbouring parts move against each other (with ten motion types, and with five). axis trains what
    chooses among candidate axes: the paper's axis selection and kinmo's own ranking. contact-edges, no part of all, is the
    gnn on edges between touching parts alone, for a row of kinmo eval --ablations. The best epoch is chosen on validation
    shapes (with --from the last one is kept, halfway to what it went on from); test shapes are never looked at. Training
    that was stopped goes on from its last epoch. On a CPU, networks that take one thread each, as those of small do, are
    trained side by side.

    With few annotated shapes, train on many procedural ones in a workspace of their own, and go on from those with --from.

    For example:

        kinmo train all
        kinmo train gnn --config paper --device cuda
        kinmo train axis --category refrigerator
        kinmo train all --workspace real --from procedural
    """
    from kinmo.pipeline.train import Train
    from kinmo.workspace import Workspace

    continued = None if start is None else Workspace(start)
    stage = Train(
        what.value,
        Workspace(options.workspace),
        config,
        category,
        options.seed,
        options.device,
        options.worker_count,
        continued,
    )
    execute(options, stage)
