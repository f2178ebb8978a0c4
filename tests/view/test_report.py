"""What the report calls what it shows."""

from __future__ import annotations

import json
from pathlib import Path

from trained_workspace import Recorder

from kinmo.dataset.store import INDEX
from kinmo.dataset.workspace import Workspace
from kinmo.learning.model_folder import METRICS
from kinmo.view.report import Report


def test_curves_say_which_network_they_are_of(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path)
    workspace.prepared.mkdir()
    (workspace.prepared / INDEX).touch()
    for place in ("gnn_fine", "gnn_fine/Laptop", "axis/Laptop", "ancsh/Laptop/semi/0/npcs"):
        (workspace.models / place).mkdir(parents=True)
        epochs = [{"epoch": epoch, "training/loss": 1.0, "validation/loss": 1.0} for epoch in (0, 1)]
        (workspace.models / place / METRICS).write_text(json.dumps(epochs), encoding="utf-8")
    html = Report(workspace).run(Recorder()).path.read_text(encoding="utf-8")
    for name in ("gnn_fine", "gnn_fine Laptop", "axis Laptop", "Laptop semi 0 npcs"):
        assert f">{name}: loss<" in html
