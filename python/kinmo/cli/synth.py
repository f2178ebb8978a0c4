"""kinmo synth."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from kinmo.cli.execute import execute
from kinmo.cli.options import CommonOptions
from kinmo.core.errors import InputError

MOST_SHAPES = 100_000
"""`kinmo.synth.generate.MOST_SHAPES`, without importing it."""


class LayoutName(str, Enum):
    """The layouts of `kinmo.synth`, without importing it."""

    PARTNET_MOBILITY = "partnet_mobility"
    PARTNET = "partnet"
    DSG_NET = "dsg_net"


def synth(
    options: CommonOptions,
    folder: Annotated[Path, Argument(help="Folder to write the shapes into.", show_default=False)],
    count: Annotated[
        int, Option("--count", "-n", min=1, max=MOST_SHAPES, help="Shapes a family and layout; of DSG-Net's a third.")
    ] = 12,
    family: Annotated[
        list[str] | None, Option(help="Only this family, such as laptop; may be repeated.", show_default=False)
    ] = None,
    layout: Annotated[
        list[LayoutName] | None,
        Option(help="Only this layout; may be repeated.", show_default=False),
    ] = None,
    held_back: Annotated[
        bool,
        Option("--held-back", help="Write PartNet's shapes with their joints too, into held_back/."),
    ] = False,
) -> None:
    """Write procedural shapes, for when there is no PartNet yet.

    Furniture, appliances and tools with their joints, in the layouts of PartNet-Mobility (labelled), PartNet and DSG-Net
    (unlabelled): the same files that real data comes in, their quirks included. The same seed gives the same files.

    For example:

        kinmo synth partnet/
        kinmo synth partnet/ --count 50 --family refrigerator --family door_set
    """
    from kinmo.synth.synth_stage import Synth

    layouts = tuple(name.value for name in layout or ())
    if held_back and layouts and LayoutName.PARTNET.value not in layouts:
        raise InputError("--held-back", "applies only to --layout partnet")
    execute(options, Synth(folder, count, tuple(family or ()), layouts, None, held_back, options.seed, options.worker_count))
