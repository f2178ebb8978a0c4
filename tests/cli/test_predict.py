"""Files among others that `kinmo predict` cannot use."""

from __future__ import annotations

from pathlib import Path

import pytest
from gltf_files import cabinet
from typer.testing import CliRunner

from kinmo.cli.app import app


@pytest.mark.parametrize("options", [[], ["--category", "door"]])
def test_a_scan_beside_shapes_is_no_wrong_usage(options: list[str], tmp_path: Path) -> None:
    good, scan = cabinet().write_glb(tmp_path / "good.glb"), tmp_path / "cloud.ply"
    scan.write_text("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n")
    where = ["--workspace", str(tmp_path / "workspace"), "-o", str(tmp_path / "out"), "--dry-run"]
    result = CliRunner().invoke(app, ["predict", str(scan), str(good), *options, *where])
    assert result.exit_code == 0, result.output
    assert "predict 1 shape" in result.output
