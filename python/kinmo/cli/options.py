"""Options that every command has, and the decorator that adds them."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from dataclasses import MISSING, dataclass, fields
from enum import Enum
from pathlib import Path
from typing import Annotated, Any, get_type_hints

from typer import Option

COMMON = "Options of all commands"


class MethodName(str, Enum):
    """Methods of `kinmo.methods`, listed here because help must start without heavy imports."""

    KINMO = "kinmo"
    PAPER = "paper"


class ProtocolName(str, Enum):
    """Protocols of `kinmo.pipeline.scans.scan_scores`, listed here for the same reason."""

    KINMO = "kinmo"
    ANCSH = "ancsh"


Start = Annotated[
    Path | None,
    Option("--from", help="Workspace whose trained networks to continue from (kinmo's own method).", show_default=False),
]


Cluster = Annotated[
    str | None,
    Option(
        metavar="ADDRESS",
        help="Ray cluster that runs the jobs: HOST:PORT, auto, or local (pip install 'kinmo\\[cluster]').",
        show_default=False,
    ),
]


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


def with_common_options(function: Callable[..., Any], without: Sequence[str] = ()) -> Callable[..., Any]:
    """Turn a function of `CommonOptions` and other parameters into a function of the latter and each common option.

    Args:
        function: The command; its first parameter is the `CommonOptions`.
        without: Common options that the command does not need; they keep their defaults.
    """
    own = list(inspect.signature(function).parameters.values())[1:]
    hints = get_type_hints(function, include_extras=True)
    common = get_type_hints(CommonOptions, include_extras=True)
    keyword = inspect.Parameter.KEYWORD_ONLY
    parameters = [p.replace(kind=keyword, annotation=hints[p.name]) for p in own]
    given = [entry for entry in fields(CommonOptions) if entry.name not in without]
    for entry in given:
        assert entry.default is not MISSING
        parameters.append(inspect.Parameter(entry.name, keyword, default=entry.default, annotation=common[entry.name]))

    def call(**values: Any) -> Any:
        options = CommonOptions(**{entry.name: values.pop(entry.name) for entry in given})
        return function(options, **values)

    call.__name__, call.__doc__, call.__module__ = function.__name__, function.__doc__, function.__module__
    call.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    call.__annotations__ = {p.name: p.annotation for p in parameters}
    return call
