"""The lock of a folder: one process at a time writes into it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from kinmo.core.errors import InputError
from kinmo.io.folder_lock import InUse, locked

SCRIPT = (
    "import sys; from pathlib import Path; from kinmo.io.folder_lock import locked\n"
    "with locked(Path(sys.argv[1])):\n"
    "    print('locked', flush=True); sys.stdin.read()"
)


def test_one_process_at_a_time_writes_into_a_folder(tmp_path: Path) -> None:
    folder = tmp_path / "w"
    command = [sys.executable, "-c", SCRIPT, str(folder)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "locked\n"
        with pytest.raises(InUse, match=f"process {other.pid}") as raised, locked(folder):
            pass
        assert not isinstance(raised.value, ValueError), "the user gave nothing wrong"
        other.kill()
        other.wait()
    for _ in range(2):
        with locked(folder):
            pass


def test_a_folder_that_cannot_be_created_is_an_input_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="file"), locked(tmp_path / "file" / "w"):
        pass
