"""The command `kinmo synth`."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from kinmo.cli.execute import execute
from kinmo.cli.options import CommonOptions
from kinmo.core.errors import InputError

MAX_SHAPES = 100_000
"""`kinmo.synth.generate.MAX_SHAPES`, without importing it."""


class LayoutName(str, Enum):
    """Layouts of `kinmo.synth.writers`. Typer takes no lists of literals."""

    PARTNET_MOBILITY = "partnet_mobility"
    PARTNET = "partnet"
    DSG_NET = "dsg_net"


def synth(
    options: CommonOptions,
    folder: Annotated[Path, Argument(help="Folder to write the shapes into.", show_default=False)],
    count: Annotated[
        int, Option("--count", "-n", min=1, max=MAX_SHAPES, help="Shapes per family and layout; a third of it for DSG-Net.")
    ] = 12,
    family: Annotated[
        list[str] | None, Option(help="Only this family, such as laptop. Repeatable.", show_default=False)
    ] = None,
    layout: Annotated[list[LayoutName] | None, Option(help="Only this layout. Repeatable.", show_default=False)] = None,
    oracle: Annotated[
        bool, Option("--oracle", help="Write PartNet's shapes with their joints too, into the folder oracle.")
    ] = False,
) -> None:
    """Write procedural shapes, to try kinmo without PartNet.

    Furniture, appliances and tools with their joints, in the layouts of PartNet-Mobility (labelled), PartNet and DSG-Net
    (unlabelled). The files are like the real ones, with their irregularities. The same seed gives the same files.

    For example:

        kinmo synth partnet/
        kinmo synth partnet/ --count 50 --family refrigerator --family door_set
    """
    from kinmo.synth.synth_stage import Synth

    families, layouts = tuple(family or ()), tuple(name.value for name in layout or ())
    if oracle and layouts and "partnet" not in layouts:
        raise InputError("--oracle", "applies only to --layout partnet")
    execute(options, Synth(folder, count, families, layouts, None, oracle, options.seed, options.worker_count))
