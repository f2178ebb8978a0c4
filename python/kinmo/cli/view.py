"""The command `kinmo view`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from kinmo.cli.execute import execute
from kinmo.cli.options import CommonOptions


def view(
    options: CommonOptions,
    path: Annotated[
        Path,
        Argument(help="A result of kinmo predict, a URDF or MJCF file, or any 3D file that kinmo reads.", show_default=False),
    ],
    html: Annotated[
        Path | None,
        Option(metavar="FILE", help="Write one HTML file that needs no server, instead of starting one.", show_default=False),
    ] = None,
    host: Annotated[str, Option(help="Address of the page; 0.0.0.0 lets other machines see it.")] = "127.0.0.1",
    port: Annotated[int, Option(min=1, max=65535, help="Port of the page. If it is taken, the next free one.")] = 8080,
    no_browser: Annotated[bool, Option("--no-browser", help="Print the address, and open no browser.")] = False,
    source: Annotated[
        Path | None, Option(help="File or folder of the shape, if it is in another place than before.", show_default=False)
    ] = None,
) -> None:
    r"""Look at an object in a browser, and move its joints.

    The page has a slider for each joint, its axis, its ranked alternatives and their probabilities. For a result of kinmo
    predict, corrections can be saved to overrides.toml; kinmo export then writes the other files again. Needs viser
    (pip install 'kinmo\[view]'). Ctrl-C ends it.

    With --html, the page is one file that works offline, without viser. A folder of results gives one page of all.

    For example:

        kinmo view out/cabinet
        kinmo view robot.urdf --port 9000 --no-browser
        kinmo view out/ --html objects.html
    """
    from kinmo.view.object_views import ServeObject, WritePage

    if html is not None:
        execute(options, WritePage(path, html, source))
        return
    execute(options, ServeObject(path, source, host, port, not no_browser))
