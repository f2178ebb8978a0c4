"""The program `kinmo` and its commands."""

from __future__ import annotations

import inspect
import os
import sys
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Annotated, Any

from typer import Exit, Option, Typer

from kinmo.cli import check, export, predict, prepare, pseudo_label, render, render_preview, report, synth, table, train, view
from kinmo.cli import eval as evaluation
from kinmo.cli.execute import one_line_errors
from kinmo.cli.options import CommonOptions

HELP = """Joints for 3D objects.

kinmo predicts the joints of 3D objects, with the networks that come with it or with your own. It learns how parts move from
annotated shapes (PartNet-Mobility), labels shapes that only have a part hierarchy (PartNet), and finds parts and joints in
depth scans. What it learns goes into one workspace. Every command skips finished work and continues interrupted work.

Start with:

    kinmo predict cabinet.glb -o out/  joints and URDFs for your own shapes
    kinmo view out/cabinet             look at one in a browser
    kinmo export out/                  write it again with your corrections
    kinmo check out/                   tests in simulators

Train your own networks:

    kinmo synth partnet/               procedural shapes, if you have none
    kinmo prepare partnet/             check and convert every shape
    kinmo train all                    train all networks
    kinmo eval                         the paper's tables
"""


def _for_rich(text: str) -> str:
    """Format help for Rich: each paragraph on one line, indented blocks unchanged."""
    blocks = text.strip("\n").split("\n\n")
    return "\n\n".join(f"\b\n{block}" if block.startswith("  ") else block.replace("\n", " ") for block in blocks)


MAY_BE_EMPTY = ("--package",)
"""Options with a value that may be empty."""

# Read when torch is first imported: threads that spin while they wait slow down everything else on a busy machine.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

app = Typer(
    name="kinmo",
    help=_for_rich(HELP),
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(wanted: bool) -> None:
    if wanted:
        from kinmo._core import __version__

        print(f"kinmo {__version__}")
        raise Exit


@app.callback()
def program(
    version: Annotated[bool, Option("--version", callback=_version, is_eager=True, help="Print the version and stop.")] = False,
) -> None:
    """Options of the program itself."""


def _register(name: str, function: Callable[..., None], without: Sequence[str] = ()) -> None:
    """Add a command. Its function takes `CommonOptions` and its own options; common options `without` keep their defaults."""
    own = list(inspect.signature(function, eval_str=True).parameters.values())[1:]
    common = [p for p in inspect.signature(CommonOptions, eval_str=True).parameters.values() if p.name not in without]

    def command(**values: Any) -> None:
        with one_line_errors():
            options = CommonOptions(**{p.name: values.pop(p.name) for p in common})
            function(options, **values)

    parameters = [p.replace(kind=p.KEYWORD_ONLY) for p in own + common]
    command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    command.__annotations__ = {p.name: p.annotation for p in parameters}
    app.command(name, help=_for_rich(inspect.cleandoc(function.__doc__ or "")))(command)


_register("synth", synth.synth)
_register("prepare", prepare.prepare)
_register("train", train.train)
_register("pseudo-label", pseudo_label.pseudo_label)
_register("render", render.render)
_register("eval", evaluation.evaluate)
_register("table", table.table)
_register("predict", predict.predict)
_register("export", export.export)
_register("check", check.check)
_register("view", view.view, without=["workers"])
_register("render-preview", render_preview.render_preview, without=["workers"])
_register("report", report.report, without=["workers"])


def main() -> None:
    """Run the program; never returns."""
    # Paths and names may have characters that the terminal's encoding lacks: they are shown escaped.
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    # As a path, an empty argument would mean the current folder.
    if any(not word and before not in MAY_BE_EMPTY for before, word in pairwise(sys.argv)):
        print("kinmo: an argument is empty: is a variable not set?", file=sys.stderr)
        sys.exit(2)
    app()
