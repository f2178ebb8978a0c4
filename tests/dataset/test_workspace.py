from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinmo.core.digest import digest
from kinmo.core.errors import InputError
from kinmo.core.names import name_on_disk
from kinmo.dataset.workspace import DEFAULT_METHOD, StageRecord, Workspace
from kinmo.io.atomic_files import (
    check_can_be_written,
    remove_leftovers,
    write_atomically,
    write_bytes_atomically,
    write_text_atomically,
)
from kinmo.io.file_memo import kept_while_unchanged
from kinmo.io.folder_lock import InUse


@given(st.lists(st.text() | st.text("é柜%/", min_size=20, max_size=200), unique=True))
def test_names_on_disk_are_such_that_every_file_system_takes_them_and_other_ones_for_other_text(texts) -> None:
    names = [name_on_disk(text) for text in texts]
    assert len(set(names)) == len(names)
    for name in names:
        assert "/" not in name
        assert len(name) <= 200, "with a layout and an ending there are 255 bytes"
        assert name.isascii()


words = st.text(max_size=5)
scalars = st.none() | st.booleans() | st.integers() | words
plain = scalars | st.lists(scalars, max_size=3) | st.dictionaries(words, scalars, max_size=3)


def test_a_file_is_there_only_when_it_is_whole(tmp_path):
    path = tmp_path / "deep" / "file.txt"
    with write_atomically(path) as temporary:
        temporary.write_text("half")
        assert not path.exists()
    assert path.read_text() == "half"
    with pytest.raises(RuntimeError), write_atomically(path) as temporary:
        temporary.write_text("other")
        raise RuntimeError
    assert path.read_text() == "half"
    assert [entry.name for entry in path.parent.iterdir()] == ["file.txt"]


def test_a_folder_is_replaced_as_a_whole(tmp_path):
    path = tmp_path / "folder"
    for name in ("one", "two"):
        with write_atomically(path) as temporary:
            temporary.mkdir()
            (temporary / name).write_text(name)
    assert [entry.name for entry in path.iterdir()] == ["two"]
    assert list(tmp_path.iterdir()) == [path]


def test_what_killed_runs_leave_is_cleared_away(tmp_path):
    script = (
        "import os, sys; from pathlib import Path; from kinmo.dataset.workspace import write_atomically\n"
        "with write_atomically(Path(sys.argv[1]) / 'f') as t:\n"
        "    t.write_text('x' * 1000); os.kill(os.getpid(), 9)"
    )
    done = subprocess.run([sys.executable, "-c", script, str(tmp_path)], check=False)
    assert done.returncode == -signal.SIGKILL
    assert len(list(tmp_path.iterdir())) == 1, "the test is about something"
    assert not (tmp_path / "f").exists()
    write_text_atomically(tmp_path / "f", "y")
    assert [entry.name for entry in tmp_path.iterdir()] == ["f"]
    (tmp_path / ".g.tmp~").mkdir()
    (tmp_path / ".g.tmp~" / "h").write_text("")
    remove_leftovers(tmp_path)
    assert [entry.name for entry in tmp_path.iterdir()] == ["f"]


def test_a_file_that_is_right_already_is_not_touched(tmp_path):
    path = tmp_path / "f"
    write_text_atomically(path, "é\n")
    assert path.read_bytes() == "é\n".encode()
    before = path.stat()
    write_text_atomically(path, "é\n")
    assert (path.stat().st_mtime_ns, path.stat().st_ino) == (before.st_mtime_ns, before.st_ino)
    write_text_atomically(path, "e\n")
    assert path.read_text() == "e\n"


def test_writing_nothing_is_a_mistake(tmp_path):
    with pytest.raises(FileNotFoundError), write_atomically(tmp_path / "f"):
        pass


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


def test_a_file_is_read_again_only_after_it_changed(tmp_path, monkeypatch):
    monkeypatch.setattr("kinmo.io.file_memo._SETTLED", -1)
    path, read = tmp_path / "file", []

    @kept_while_unchanged
    def text(path):
        read.append(path)
        return path.read_text(encoding="utf-8")

    with pytest.raises(FileNotFoundError):
        text(path)
    read.clear()
    for count, contents in enumerate(("a", "longer", "b"), start=1):
        write_bytes_atomically(path, contents.encode())
        assert [text(path), text(path), text(Path(str(path)))] == [contents] * 3
        assert len(read) == count
    path.unlink()
    with pytest.raises(FileNotFoundError):
        text(path)


def test_of_a_file_that_has_just_changed_nothing_is_kept(tmp_path):
    path, first_byte = tmp_path / "file", kept_while_unchanged(lambda path: path.read_bytes()[:1])
    for contents in (b"a", b"b", b"c") * 20:
        path.write_bytes(contents)
        assert first_byte(path) == contents


@given(st.dictionaries(words, plain, min_size=1, max_size=4))
def test_a_digest_does_not_depend_on_the_order_of_keys(value):
    assert digest(value) == digest(dict(reversed(value.items())))
    assert digest(value) != digest({**value, "one more key": 1})


def test_records_are_the_same_bytes_whenever_they_are_written(tmp_path):
    for name in ("a", "b"):
        Workspace(tmp_path / name).write_record("gnn", StageRecord({"y": 1, "x": [1, 2]}, ("models/x",)))
    files = [(tmp_path / name / "records" / "gnn.json").read_bytes() for name in ("a", "b")]
    assert files[0] == files[1]
    assert [entry.name for entry in (tmp_path / "a").iterdir()] == ["records"]


def test_a_full_disk_names_the_file_and_leaves_what_was_there(tmp_path):
    write_bytes_atomically(tmp_path / "file", b"before")
    with (
        pytest.raises(OSError, match=r"No space left on device: .*file") as raised,
        write_atomically(tmp_path / "file") as place,
    ):
        place.write_bytes(b"half of")
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert raised.value.filename == str(tmp_path / "file")
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [b"before"]


def test_what_goes_wrong_in_writing_names_the_file_and_not_where_it_was_first_put(tmp_path):
    with pytest.raises(OSError) as caught, write_atomically(tmp_path / "a.json") as temporary:
        temporary.mkdir()
        temporary.write_text("a file where there is a folder")
    assert caught.value.filename == str(tmp_path / "a.json")


def test_a_folder_that_can_be_written_to_is_told_without_making_it(tmp_path, monkeypatch):
    check_can_be_written(tmp_path / "a" / "b")
    assert not list(tmp_path.iterdir())
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="file: expected a folder: this is a file"):
        check_can_be_written(tmp_path / "file")
    with pytest.raises(InputError, match=r"below: .*file is a file, not a folder"):
        check_can_be_written(tmp_path / "file" / "below")
    monkeypatch.setattr("kinmo.io.atomic_files.os.access", lambda path, mode: False)  # whoever runs this may be allowed all
    with pytest.raises(InputError, match="new: cannot be written to"):
        check_can_be_written(tmp_path / "new")
