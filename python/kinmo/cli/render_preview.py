"""The command `kinmo render-preview`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from kinmo.cli.execute import execute
from kinmo.cli.options import ColorsName, CommonOptions


def render_preview(
    options: CommonOptions,
    path: Annotated[
        Path,
        Argument(help="A result of kinmo predict, a URDF or MJCF file, or any 3D file that kinmo reads.", show_default=False),
    ],
    out: Annotated[Path, Option("--out", "-o", help="The file: .png, or .gif for an animation.")] = Path("preview.png"),
    size: Annotated[
        int, Option(min=16, max=4096, help="Height of each picture in pixels, before empty margins are cut off.")
    ] = 480,
    poses: Annotated[int, Option(min=1, max=12, help="Number of poses side by side, the first one at rest.")] = 3,
    opening: Annotated[float, Option(min=0.0, max=1.0, help="Share of their ranges that joints open in the last pose.")] = 0.8,
    colors: Annotated[
        ColorsName,
        Option(
            help="looks: materials and images of the file. bodies: one colour for each body. auto: looks if there are some."
        ),
    ] = "auto",
    before: Annotated[bool, Option("--before", help="Begin with the object in grey, without joints.")] = False,
    no_axes: Annotated[bool, Option("--no-axes", help="Draw no axes.")] = False,
    transparent: Annotated[bool, Option("--transparent", help="Leave the background transparent.")] = False,
    source: Annotated[
        Path | None, Option(help="File or folder of the shape, if it is in another place than before.", show_default=False)
    ] = None,
) -> None:
    """Draw an object at rest and with open joints, for papers and web pages.

    Objects look as in their file. Those without an image and without different colours have a colour for each body instead.
    Joints have arrows along their axes. A file that ends in .gif becomes an animation in which all joints open and close. No
    graphics card is needed.

    For example:

        kinmo render-preview out/cabinet -o cabinet.png
        kinmo render-preview out/cabinet -o cabinet.gif --size 320
        kinmo render-preview out/cabinet --colors bodies
        kinmo render-preview robot.urdf --poses 5 --transparent
    """
    from kinmo.view.preview_files import RenderPreview

    execute(options, RenderPreview(path, out, source, size, poses, opening, before, not no_axes, transparent, colors))
