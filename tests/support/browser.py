"""Opening a page in a browser, where the machine has one."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
needs_browser = pytest.mark.skipif(BROWSER is None, reason="no chromium on this machine")
PROBE = "<script>document.title = document.documentElement.scrollWidth + '/' + document.documentElement.clientWidth</script>"


def assert_shown_without_complaint(html: str, width: int, folder: Path) -> None:
    """No word in the console, and no scrolling sideways in a window of `width` pixels."""
    file = folder / "page.html"
    file.write_text(html.replace("</body>", PROBE + "</body>"), encoding="utf-8")
    command = [str(BROWSER), "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--v=0",
               f"--user-data-dir={folder / 'profile'}", f"--window-size={width},900", "--virtual-time-budget=2000",
               "--dump-dom", file.as_uri()]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    assert "CONSOLE" not in done.stderr
    sizes = re.search(r"<title>(\d+)/(\d+)</title>", done.stdout)
    assert sizes is not None
    assert int(sizes[1]) <= int(sizes[2])
