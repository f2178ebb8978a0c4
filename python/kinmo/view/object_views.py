"""The stage `view`: a page that shows an object, by a server or as one HTML file."""

from __future__ import annotations

import threading
import webbrowser
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.core.wording import counted
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.view.opened_item import open_items, open_one
from kinmo.view.static_page import write_static_page

HOST, PORT = "127.0.0.1", 8080
"""Address of the page. Other machines cannot see it."""


@dataclass(frozen=True)
class ServeObject:
    """Show one object in a browser until Ctrl-C."""

    path: Path
    source: Path | None = None
    host: str = HOST
    port: int = PORT
    opens_browser: bool = True

    def plan(self) -> Plan:
        """Read the object."""
        self._check()
        opened = open_one(self.path, self.source)
        return Plan((f"show {opened.scene().name} at http://{self.host}:{self.port}, until Ctrl-C",), 1.0)

    def run(self, observer: Observer) -> Outcome:
        """Serve the page until the process is interrupted."""
        from kinmo.view.viser_server import ObjectServer

        self._check()
        opened = open_one(self.path, self.source)
        opened.note_repairs(observer)
        server = ObjectServer(opened.item, opened.folder, host=self.host, port=self.port)
        try:
            observer.note(f"{server.url}  (Ctrl-C ends it)")
            if self.opens_browser:
                webbrowser.open(server.url)
            wait_for_ever()
        except KeyboardInterrupt:
            pass
        finally:
            server.stop()
        return Outcome(self.path, {"path": str(self.path), "url": server.url})

    def _check(self) -> None:
        if find_spec("viser") is None:
            problem = "needs viser: pip install 'kinmo[view]'; or write a page that needs nothing: add --html page.html"
            raise InputError("kinmo view", problem)


def wait_for_ever() -> None:
    """Wait until the process is interrupted."""
    threading.Event().wait()


@dataclass(frozen=True)
class WritePage:
    """Write one HTML file that shows all objects at a path, without a server."""

    path: Path
    html: Path
    source: Path | None = None

    def plan(self) -> Plan:
        """Read the objects."""
        count = len(open_items(self.path, self.source))
        return Plan((f"write {self.html}: {counted(count, 'object')}",), float(count))

    def run(self, observer: Observer) -> Outcome:
        """Write the page."""
        if self.html.is_dir():
            raise InputError(self.html, "is a folder: name a file, such as page.html")
        scenes = []
        items = open_items(self.path, self.source)
        for done, opened in enumerate(items, 1):
            opened.note_repairs(observer)
            scenes.append(opened.scene())
            observer.progress("reading", done, len(items), scenes[-1].name)
        self.html.parent.mkdir(parents=True, exist_ok=True)
        write_static_page(scenes, self.html)
        return Outcome(self.html, {"html": str(self.html), "objects": [scene.name for scene in scenes]})
