"""Tables whose rows differ in the shapes that have labels, or in the sensor, made whole."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
from scan_road import CATEGORY, FAMILY, HOW, Scanned
from whole_road import Listener

from kinmo.config import ScansConfig
from kinmo.pipeline.dataset import open_dataset
from kinmo.pipeline.model_files import WEIGHTS
from kinmo.pipeline.scans.make_table import MakeTable
from kinmo.pipeline.scans.table_rows import SHARES, TABLES
from kinmo.scans.scan import scan
from kinmo.scans.scan_file import open_scans, write_scans
from kinmo.splits import Split
from kinmo.workspace import Workspace
from scanned import cupboard_object


def make(name: str, method: str, scanned: Scanned, folder: Path) -> MakeTable:
    """A table, made in a workspace of its own."""
    shutil.copytree(scanned.workspace.path, folder / "workspace")
    shutil.rmtree(folder / "workspace" / "eval", ignore_errors=True)  # of other tests
    stage = MakeTable(name, Workspace(folder / "workspace"), scanned.config, (method,), FAMILY, 1, **HOW)  # type: ignore[arg-type]
    stage.run(Listener())
    return stage


def test_two_trainings_are_judged_on_the_scans_of_both_sensors(scanned: Scanned, tmp_path: Path) -> None:
    stage = make("sensors", "kinmo", scanned, tmp_path)
    assert stage.plan().steps == ()
    root, rough = stage.workspace, Workspace(stage.workspace.root, is_rough=True)
    weights = [row.cell(CATEGORY, 0).weights(row.workspace(root)) for row in TABLES["sensors"].rows]
    assert all(weights)
    assert weights[0] == weights[1] != weights[2] == weights[3]
    found = [row.judged(root, CATEGORY, 0).held() for row in TABLES["sensors"].rows]
    assert all(found)
    assert len({str(made) for made in found}) == 4
    clean = open_scans(next((root.scans / CATEGORY / "test").glob("*.safetensors")))
    noisy = open_scans(rough.scans / CATEGORY / "test" / clean.path.name)
    np.testing.assert_array_equal(clean.read("poses"), noisy.read("poses"))
    assert not np.array_equal(clean.read("points"), noisy.read("points"))
    for path in (root.scans / CATEGORY / "train").glob("*.safetensors"):  # as if other joints had been asked for
        provenance, target = open_scans(path).provenance, cupboard_object()
        write_scans(path, target, scan(target, ScansConfig(states=1, views=4, size=64, points=64), 0), provenance)
    assert not any(row.judged(root, CATEGORY, 0).held() for row in TABLES["sensors"].rows)


def test_each_share_of_the_labels_has_motion_networks_of_its_own(scanned: Scanned, tmp_path: Path) -> None:
    stage = make("3", "paper", scanned, tmp_path)
    labelled = set()
    for share in SHARES:
        workspace, labels = (Workspace(stage.workspace.root, share, method=method) for method in ("kinmo", "paper"))
        entries = open_dataset(workspace).labelled[Split.TRAIN]
        labelled.add(len(entries))
        for model in ("gnn_fine", "axis"):
            record = workspace.record(f"train-{model}")
            assert record is not None
            assert record.inputs["data"]["training"] == open_dataset(workspace).fingerprint(entries)
            assert (workspace.models / model / WEIGHTS).is_file()
        assert not (labels.models / "axis").exists(), "methods share motion networks"
        assert labels.record("pseudo-label") is not None
        assert workspace.record("pseudo-label") is None, "of the other method, which was not asked for"
    assert len(labelled) >= 3, "one to four shapes"
