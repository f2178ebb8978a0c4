"""A workspace is used by one process at a time, and knows which stages are up to date."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from kinmo.core.errors import InputError
from kinmo.dataset.cache import FILE
from kinmo.dataset.workspace import Workspace
from kinmo.io.atomic_files import write_bytes_atomically
from kinmo.io.folder_lock import InUse


def trained(workspace: Workspace, inputs: dict[str, object]) -> Path:
    """Record a stage with one output, and return the output."""
    output = workspace.models / "gnn.safetensors"
    write_bytes_atomically(output, b"weights")
    workspace.record("gnn", inputs, [output])
    return output


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
    assert not isinstance(raised.value, ValueError), "no input is wrong"
    other.kill()
    other.wait()
    other.stdin.close()
    other.stdout.close()
    with workspace.locked():
        pass
    with workspace.locked():
        pass


def test_a_workspace_below_a_file_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="file"), Workspace(tmp_path / "file" / "w").locked():
        pass


def test_a_workspace_may_share_folders_of_another(tmp_path):
    whole = Workspace(tmp_path)
    part = Workspace(tmp_path / "part", prepared=whole.prepared, pseudo_labels=whole.pseudo_labels, journal=whole.journal)
    assert (part.prepared, part.pseudo_labels, part.journal) == (whole.prepared, whole.pseudo_labels, whole.journal)
    assert part.models != whole.models and part.scans != whole.scans
    assert part != Workspace(
        part.path, prepared=part.prepared, pseudo_labels=part.pseudo_labels, journal=part.journal, select=list
    )
    assert part != Workspace(tmp_path / "part") and Workspace(str(tmp_path)) == whole
    assert len({whole, Workspace(tmp_path), part}) == 2


def test_a_stage_is_current_only_with_the_same_inputs_and_all_outputs(tmp_path):
    workspace = Workspace(tmp_path)
    inputs = {"config": {"epochs": 3}, "seed": 0, "shapes": ("a", "b")}
    assert not workspace.is_current("gnn", inputs)
    output = trained(workspace, inputs)
    assert workspace.is_current("gnn", inputs)
    assert workspace.inputs_of("gnn") == {"config": {"epochs": 3}, "seed": 0, "shapes": ["a", "b"]}
    assert not workspace.is_current("gnn", inputs | {"seed": 1})
    assert not workspace.is_current("axis", inputs)
    output.unlink()
    assert not workspace.is_current("gnn", inputs)
    assert workspace.inputs_of("gnn") is None


@pytest.mark.parametrize("damaged", [b"", b"weig", b"weighty"])
def test_a_stage_with_a_damaged_output_is_done_again(tmp_path, damaged):
    workspace = Workspace(tmp_path)
    output = trained(workspace, {})
    output.write_bytes(damaged)
    assert not workspace.is_current("gnn", {})
    output.write_bytes(b"weights")
    assert workspace.is_current("gnn", {})


def test_a_record_of_another_version_does_not_count(tmp_path, monkeypatch):
    workspace = Workspace(tmp_path)
    with monkeypatch.context() as patched:
        patched.setattr("kinmo.dataset.cache.__version__", "0.0.0")
        trained(workspace, {})
    assert workspace.inputs_of("gnn") == {}
    assert not workspace.is_current("gnn", {})


def test_a_garbled_record_does_not_count(tmp_path):
    workspace = Workspace(tmp_path)
    trained(workspace, {})
    (tmp_path / FILE).write_text('{"name": "gnn", "key": ')
    assert not workspace.is_current("gnn", {})
    trained(workspace, {})
    assert workspace.is_current("gnn", {})


def test_a_forgotten_stage_is_done_again(tmp_path):
    workspace = Workspace(tmp_path)
    trained(workspace, {})
    workspace.forget("gnn")
    workspace.forget("gnn")
    assert not workspace.is_current("gnn", {})
