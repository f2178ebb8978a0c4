"""HTML pages with 3D objects: one file, no server, nothing fetched."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from importlib import resources
from pathlib import Path

import jinja2

from kinmo.core.wording import clean_text, counted
from kinmo.io.atomic_files import write_text_atomically
from kinmo.view.object_scene import ObjectScene
from kinmo.view.scene_data import scene_json

MAX_PAGE_BYTES = 48 << 20
"""Largest size of all objects of a page together. Objects that do not fit are left out with a note."""


def viewer_script() -> str:
    """The JavaScript of the viewer. It defines `kinmoViewer`."""
    return _file("object_viewer.js")


def viewer_style() -> str:
    """The style sheet of the viewer."""
    return _file("object_viewer.css")


def static_page(scenes: Sequence[ObjectScene], title: str | None = None, most: int = MAX_PAGE_BYTES) -> str:
    """The HTML page of some objects. With several, a menu chooses the one that is shown.

    Args:
        scenes: The objects, at least one.
        title: Title of the page. None for the name of the first object.
        most: Largest size of all objects together in bytes. The first object is always there.

    Returns:
        The page. It needs a browser with WebGL 2 and no network.
    """
    texts: list[str] = []
    names: list[str] = []
    left_out: list[str] = []
    size = 0
    for scene in scenes:
        text = scene_json(scene)
        size += len(text)
        if texts and size > most:
            size -= len(text)
            left_out.append(clean_text(scene.name))
            continue
        texts.append(text)
        names.append(clean_text(scene.name))
    note = f"Left out, as the page would be too large: {counted(len(left_out), 'object')} ({', '.join(left_out[:20])})."
    return _template().render(
        title=title or names[0],
        names=names,
        scenes=texts,
        note=note if left_out else "",
        script=viewer_script(),
        style=viewer_style(),
    )


def write_static_page(scenes: Sequence[ObjectScene], path: Path, title: str | None = None) -> Path:
    """Write the HTML page of some objects. Returns its path."""
    write_text_atomically(path, static_page(scenes, title))
    return path


def _file(name: str) -> str:
    return resources.files("kinmo.view").joinpath(name).read_text(encoding="utf-8")


@cache
def _template() -> jinja2.Template:
    environment = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined)
    return environment.from_string(_file("static_page.html.j2"))
