"""Objects and results to look at: pages in a browser, pictures, and the report of a workspace.

Example:
    >>> from kinmo.view import preview, save_page, show
    >>> prediction = kinmo.Prediction.load("out/cabinet")
    >>> save_page([prediction], "cabinet.html")
    >>> page = show(prediction, "out/cabinet")
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from PIL.Image import Image

    from kinmo.api.prediction import Prediction
    from kinmo.core.shape import Shape
    from kinmo.view.preview_pictures import PreviewColors
    from kinmo.view.viser_server import ObjectServer

__all__ = ["preview", "save_page", "show"]


def show(
    item: Prediction | Shape, folder: Path | str | None = None, *, host: str = "127.0.0.1", port: int = 8080
) -> ObjectServer:
    """Serve a page with an object, its joints and their alternatives. Returns at once.

    Args:
        item: A prediction, or a shape with its own joints.
        folder: Folder of joints.json, where corrections are saved. None for no saving.
        host: Address that the page listens at. "0.0.0.0" lets other machines see it.
        port: Port of the page. If it is taken, the next free one is used.

    Returns:
        The server, with its address `url` and a method `stop`.

    Raises:
        InputError: viser is not installed, or an overrides.toml in `folder` is wrong.

    Example:
        >>> page = show(prediction, "out/cabinet")
        >>> page.url
        'http://127.0.0.1:8080'
    """
    from kinmo.view.viser_server import ObjectServer

    return ObjectServer(item, None if folder is None else Path(folder), host=host, port=port)


def save_page(items: Sequence[Prediction | Shape], path: Path | str) -> Path:
    """Write one HTML file that shows objects in 3D, without a server or a network.

    Args:
        items: Predictions, or shapes with their own joints. At least one.
        path: The file to write.

    Returns:
        Its path.

    Example:
        >>> save_page([prediction], "cabinet.html")
    """
    from kinmo.view.scene_building import scene_of
    from kinmo.view.static_page import write_static_page

    return write_static_page([scene_of(item) for item in items], Path(path))


def preview(
    item: Prediction | Shape,
    *,
    size: int = 480,
    poses: int = 3,
    opening: float = 0.8,
    has_axes: bool = True,
    colors: PreviewColors = "auto",
) -> Image:
    """Draw an object at rest and with open joints, side by side.

    Args:
        item: A prediction, or a shape with its own joints.
        size: Height of each picture in pixels, before empty margins are cut off.
        poses: Number of poses, the first one at rest.
        opening: Share of their ranges that joints open in the last pose.
        has_axes: True to draw the axes of the joints.
        colors: "looks" for the materials and images of the file, "bodies" for one colour for each body. "auto" takes the
            looks if there is an image or more than one colour.

    Returns:
        The picture, with a white background.

    Raises:
        InputError: `colors` has another value.

    Example:
        >>> preview(prediction).save("cabinet.png")
    """
    from kinmo.view.preview_pictures import Preview, PreviewStyle
    from kinmo.view.scene_building import scene_of

    scene = scene_of(item)
    shares = [opening * place / max(poses - 1, 1) for place in range(poses)]
    return Preview(scene, PreviewStyle(size, has_axes, colors=colors)).strip([scene.opened(share) for share in shares])
