"""Options that several commands have. Choices are listed here, because help must start without heavy imports."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from typer import Option

from kinmo.core.errors import InputError

COMMON = "Options of all commands"

MethodName = Literal["kinmo", "paper"]
"""Methods of `kinmo.methods`."""
ProtocolName = Literal["kinmo", "ancsh"]
"""Protocols of `kinmo.pipeline.scans.scan_scores`."""

Config = Annotated[
    str, Option("--config", "-c", help="small (a CPU), paper (a GPU), shipped (as kinmo's own networks), or a TOML file.")
]
Category = Annotated[str | None, Option(help="Only shapes of this category, in any spelling.", show_default=False)]
Details = Annotated[bool, Option("--details", help="Print all figures, with intervals and notes.")]
Start = Annotated[
    Path | None,
    Option(
        "--from",
        metavar="WORKSPACE",
        help="Workspace whose networks the kinmo method continues from; shipped: those that come with kinmo.",
        show_default=False,
    ),
]
CollisionName = Literal["convex", "hull", "mesh", "none"]
"""Modes of `kinmo.robot.collision_geometry`."""
AxisName = Literal["x", "y", "z", "-x", "-y", "-z"]
"""Axes of `kinmo.core.frames`."""
ColorsName = Literal["auto", "looks", "bodies"]
"""Colours of `kinmo.view.preview_pictures`."""
Cluster = Annotated[
    str | None,
    Option(
        metavar="ADDRESS",
        help="Ray cluster that runs the jobs: HOST:PORT, auto, or local (pip install 'kinmo\\[cluster]').",
        show_default=False,
    ),
]


def names_in(text: str) -> tuple[str, ...]:
    """Names with commas between them, each once."""
    return tuple(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))


@dataclass(frozen=True)
class CommonOptions:
    """Values of the options that every command has; the help texts describe them."""

    workspace: Annotated[
        Path,
        Option(
            "--workspace", "-w", envvar="KINMO_WORKSPACE", help="Folder for everything kinmo makes.", rich_help_panel=COMMON
        ),
    ] = Path("workspace")
    device: Annotated[
        str, Option(help="Where networks run: auto, cpu, cuda, cuda:1, mps.", metavar="NAME", rich_help_panel=COMMON)
    ] = "auto"
    seed: Annotated[int, Option(min=0, help="Seed of everything random.", rich_help_panel=COMMON)] = 0
    workers: Annotated[
        int, Option(min=0, help="Number of processes; 0 for one per CPU core.", show_default="0", rich_help_panel=COMMON)
    ] = 0
    dry_run: Annotated[
        bool, Option("--dry-run", help="Show what would run, and for how long; do nothing.", rich_help_panel=COMMON)
    ] = False
    quiet: Annotated[
        bool, Option("--quiet", "-q", help="Show no progress and no tables, only problems.", rich_help_panel=COMMON)
    ] = False
    json: Annotated[bool, Option("--json", help="Print the result as JSON instead of its path.", rich_help_panel=COMMON)] = (
        False
    )

    @property
    def worker_count(self) -> int:
        """`workers`, with 0 replaced by the number of CPU cores that this process may use."""
        from kinmo.api.stages import worker_count

        return worker_count(self.workers)


def refuse(options: Mapping[str, object], problem: str) -> None:
    """Raise InputError for the first of some options that is given, by its name."""
    for name, value in options.items():
        if value not in (None, False):
            raise InputError(name, problem)
