"""Scans for the tests of ANCSH."""

from __future__ import annotations

import pytest
from scanned_objects import cupboard_object

from kinmo.config import ScansConfig
from kinmo.scans.files.scan_file import ScanFile, ScanProvenance, open_scans, write_scans
from kinmo.scans.rendering.labelled_frames import scan_object


@pytest.fixture(scope="package")
def file(tmp_path_factory: pytest.TempPathFactory) -> ScanFile:
    """24 scans of a cupboard with hinges and a drawer."""
    target = cupboard_object()
    path = tmp_path_factory.mktemp("scans") / "cupboard.safetensors"
    write_scans(path, target, scan_object(target, ScansConfig(states=6, views=4, size=128, points=256), 0), ScanProvenance())
    return open_scans(path)
