"""Scans to show the networks of ANCSH."""

from __future__ import annotations

import pytest

from kinmo.config import ScansConfig
from kinmo.scans.labelled_frames import scan
from kinmo.scans.scan_file import Provenance, ScanFile, open_scans, write_scans
from scanned import cupboard_object


@pytest.fixture(scope="package")
def file(tmp_path_factory: pytest.TempPathFactory) -> ScanFile:
    """24 scans of a cupboard with hinges and a drawer."""
    target = cupboard_object()
    path = tmp_path_factory.mktemp("scans") / "cupboard.safetensors"
    write_scans(path, target, scan(target, ScansConfig(states=6, views=4, size=128, points=256), 0), Provenance())
    return open_scans(path)
