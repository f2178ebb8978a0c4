from __future__ import annotations

import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinmo.core.errors import InputError
from kinmo.dataset.workspace import DEFAULT_METHOD, StageRecord, Workspace
from kinmo.io.atomic_files import (
    write_bytes_atomically,
)
from kinmo.io.folder_lock import InUse


def test_one_process_at_a_time_works_in_a_workspace(tmp_path):
    workspace = Workspace(tmp_path / "w")
    script = (
        "import sys; from kinmo.dataset.workspace import Workspace\n"
        "with Workspace(sys.argv[1]).locked():\n"
        "    print('locked', flush=True); sys.stdin.read()"
    )
    command = [sys.executable, "-c", script, str(workspace.path)]
    other = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert other.stdout.readline() == "locked\n"
    with pytest.raises(InUse, match=f"process {other.pid}") as raised, workspace.locked():
        pass
    assert not isinstance(raised.value, ValueError), "nothing that was given is wrong"
    other.kill()
    other.wait()
    other.stdin.close()
    other.stdout.close()
    with workspace.locked():
        pass
    with workspace.locked():
        pass


def test_a_workspace_that_cannot_be_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="file"), Workspace(tmp_path / "file" / "w").locked():
        pass


@given(st.sampled_from([1.0, 0.5, 0.3]), st.sampled_from([DEFAULT_METHOD, "paper"]))
def test_what_no_sensor_is_needed_for_is_not_made_anew_for_another(labels, method):
    clean, rough = (Workspace("w", labels, is_rough, method) for is_rough in (False, True))
    assert rough.pseudo == clean.pseudo
    assert rough.labelling == clean
    assert rough.motion == clean.motion == Workspace("w", labels)
    assert {rough.scans, rough.own_scans, rough.models, rough.evaluation}.isdisjoint(
        {clean.scans, clean.own_scans, clean.models, clean.evaluation}
    )
    assert rough.without_pseudo_labels == Workspace("w", labels, is_rough=True)


def test_a_stage_is_current_only_with_the_same_inputs_and_all_outputs(tmp_path):
    workspace = Workspace(tmp_path)
    inputs = {"config": {"epochs": 3}, "seed": 0, "shapes": ("a", "b")}
    assert not workspace.is_current("gnn", inputs)
    write_bytes_atomically(workspace.models / "gnn.safetensors", b"weights")
    workspace.write_record("gnn", StageRecord(inputs, ("models/gnn.safetensors",)))
    assert workspace.is_current("gnn", inputs)
    assert not workspace.is_current("gnn", inputs | {"seed": 1})
    assert not workspace.is_current("axis", inputs)
    (workspace.models / "gnn.safetensors").unlink()
    assert not workspace.is_current("gnn", inputs)


@pytest.mark.parametrize("damaged", [b"", b"weig", b"weighty"])
def test_a_stage_with_a_damaged_output_is_to_be_done_again(tmp_path, damaged):
    workspace = Workspace(tmp_path)
    write_bytes_atomically(workspace.models / "gnn.safetensors", b"weights")
    workspace.write_record("gnn", StageRecord({}, ("models/gnn.safetensors",)))
    (workspace.models / "gnn.safetensors").write_bytes(damaged)
    assert not workspace.is_current("gnn", {})
    (workspace.models / "gnn.safetensors").write_bytes(b"weights")
    assert workspace.is_current("gnn", {})


def test_a_record_of_another_version_or_garbled_counts_for_nothing(tmp_path):
    workspace = Workspace(tmp_path)
    workspace.write_record("gnn", StageRecord({}, (), kinmo="0.0.0"))
    assert workspace.record("gnn") is not None
    assert not workspace.is_current("gnn", {})
    (tmp_path / "records" / "gnn.json").write_text('{"inputs": ')
    assert workspace.record("gnn") is None
    workspace.write_record("gnn", StageRecord({}))
    assert workspace.is_current("gnn", {})
    workspace.forget("gnn")
    workspace.forget("gnn")
    assert not workspace.is_current("gnn", {})


def test_records_are_the_same_bytes_whenever_they_are_written(tmp_path):
    for name in ("a", "b"):
        Workspace(tmp_path / name).write_record("gnn", StageRecord({"y": 1, "x": [1, 2]}, ("models/x",)))
    files = [(tmp_path / name / "records" / "gnn.json").read_bytes() for name in ("a", "b")]
    assert files[0] == files[1]
    assert [entry.name for entry in (tmp_path / "a").iterdir()] == ["records"]
