"""Options that every command has, and the decorator that gives them to it."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Sequence
from dataclasses import MISSING, dataclass, fields
from enum import Enum
from pathlib import Path
from typing import Annotated, Any, get_type_hints

from typer import Option

COMMON = "Options of all commands"


class Method(str, Enum):
    """The methods of `kinmo.pipeline.predictors`, without importing it."""

    KINMO = "kinmo"
    PAPER = "paper"


class ProtocolName(str, Enum):
    """The protocols of `kinmo.pipeline.scans.scan_networks`, without importing it."""

    KINMO = "kinmo"
    ANCSH = "ancsh"


Start = Annotated[
    Path | None,
    Option("--from", help="A workspace with trained motion networks to go on from (kinmo's own method).", show_default=False),
]


@dataclass(frozen=True)
class CommonOptions:
    """See the help texts."""

    workspace: Annotated[
        Path,
        Option("--workspace", "-w", envvar="KINMO_WORKSPACE", help="Folder of everything kinmo makes.", rich_help_panel=COMMON),
    ] = Path("workspace")
    device: Annotated[
        str, Option(help="Where networks run: auto, cpu, cuda, cuda:1, mps.", metavar="NAME", rich_help_panel=COMMON)
    ] = "auto"
    seed: Annotated[int, Option(min=0, help="Seed of everything random.", rich_help_panel=COMMON)] = 0
    workers: Annotated[
        int,
        Option(min=0, help="Processes that share the work; 0 is one a CPU core.", show_default="0", rich_help_panel=COMMON),
    ] = 0
    dry_run: Annotated[
        bool, Option("--dry-run", help="Say what would run, and about how long, and stop.", rich_help_panel=COMMON)
    ] = False
    quiet: Annotated[
        bool, Option("--quiet", "-q", help="No progress, no tables; what goes wrong is told.", rich_help_panel=COMMON)
    ] = False
    json: Annotated[
        bool, Option("--json", help="Print the result itself, as JSON, in place of its path.", rich_help_panel=COMMON)
    ] = False

    @property
    def worker_count(self) -> int:
        """`workers`, with 0 replaced by the number of CPU cores this process may use."""
        return self.workers or len(os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else range(os.cpu_count() or 1))


def with_common_options(function: Callable[..., Any], without: Sequence[str] = ()) -> Callable[..., Any]:
    """`function(options: CommonOptions, ...)` as a function of its other parameters and, after them, the common options.

    Those named in `without`, which mean nothing to the command, keep their defaults and cannot be given.
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
