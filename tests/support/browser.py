"""HTML pages in a real browser, on machines that have one."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
needs_browser = pytest.mark.skipif(BROWSER is None, reason="no chromium on this machine")
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
