"""HTML pages in a real browser, on machines that have one."""

from __future__ import annotations

import io
import re
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
needs_browser = pytest.mark.skipif(BROWSER is None, reason="no chromium on this machine")
needs_driven_browser = pytest.mark.skipif(
    BROWSER is None or find_spec("playwright") is None, reason="no chromium on this machine, or no playwright to drive it"
)
SOFTWARE_3D = (
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
)
"""Options of a browser that draws WebGL without a graphics card."""
READY = "[data-state=ready]"
"""A viewer that has drawn its object."""
SIZES = "<script>document.title = document.documentElement.scrollWidth + '/' + document.documentElement.clientWidth</script>"
"""Writes the width of the content and of the window into the title of the page."""


def assert_shown_without_complaint(html: str, width: int, folder: Path) -> None:
    """Check that a page writes nothing to the console and fits into a window of `width` pixels."""
    file = folder / "page.html"
    file.write_text(html.replace("</body>", SIZES + "</body>"), encoding="utf-8")
    command = [str(BROWSER), "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--v=0",
               f"--user-data-dir={folder / 'profile'}", f"--window-size={width},900", "--virtual-time-budget=2000",
               "--dump-dom", file.as_uri()]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    assert "CONSOLE" not in done.stderr
    sizes = re.search(r"<title>(\d+)/(\d+)</title>", done.stdout)
    assert sizes is not None
    assert int(sizes[1]) <= int(sizes[2])


@dataclass
class OpenPage:
    """A page in a running browser."""

    page: Any
    complaints: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def picture(self) -> np.ndarray:
        """Pixels [height, width, 3] of the window, as integers."""
        return np.asarray(Image.open(io.BytesIO(self.page.screenshot(timeout=180_000))).convert("RGB"), int)

    def settled_picture(self) -> np.ndarray:
        """The picture when it has stopped changing."""
        last = self.picture()
        for _ in range(40):
            self.page.wait_for_timeout(250)
            now = self.picture()
            if np.array_equal(now, last):
                return now
            last = now
        raise AssertionError("the page never comes to rest")

    def scrolls_sideways(self) -> bool:
        """True if the page is wider than the window."""
        return bool(self.page.evaluate("document.documentElement.scrollWidth > window.innerWidth"))


_RUNNING: list[Any] = []
"""The browser that is open, if any: playwright runs one at a time."""


@contextmanager
def running_browser() -> Iterator[Any]:
    """The open browser, or a new one."""
    from playwright.sync_api import sync_playwright

    if _RUNNING:
        yield _RUNNING[0]
        return
    with sync_playwright() as playwright:
        _RUNNING.append(playwright.chromium.launch(executable_path=BROWSER, args=list(SOFTWARE_3D)))
        try:
            yield _RUNNING[0]
        finally:
            _RUNNING.pop().close()


@contextmanager
def open_page(url: str, width: int = 1280, height: int = 800) -> Iterator[OpenPage]:
    """Open a page. Warnings count as no complaint: a browser without a graphics card gives some."""
    with running_browser() as browser:
        opened = OpenPage(browser.new_page(viewport={"width": width, "height": height}))
        opened.page.on("console", lambda each: opened.complaints.append(each.text) if each.type == "error" else None)
        opened.page.on("pageerror", lambda error: opened.complaints.append(str(error)))
        opened.page.on("request", lambda request: opened.requests.append(request.url))
        opened.page.goto(url)
        try:
            yield opened
        finally:
            opened.page.close()
