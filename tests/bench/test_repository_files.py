"""Files of clones, git folders and unpacked archives."""

from __future__ import annotations

import subprocess

import pytest

import repository_files


def git(folder, *arguments):
    user = ("-c", "user.name=a", "-c", "user.email=a@b", "-c", "init.defaultBranch=main")
    done = subprocess.run(["git", *user, "-C", str(folder), *arguments], check=True, capture_output=True, text=True)
    return done.stdout.strip()


@pytest.fixture
def clone(tmp_path):
    """A clone of two commits, with the first of them."""
    folder = tmp_path / "clones" / "maker+box"
    (folder / "box" / "meshes").mkdir(parents=True)
    (folder / "box" / "meshes" / "lid.OBJ").write_text("old")
    (folder / "box" / "colour.png").write_text("a picture")
    (folder / "other.obj").write_text("other")
    git(folder, "init")
    git(folder, "add", ".")
    git(folder, "commit", "-m", "one")
    first = git(folder, "rev-parse", "HEAD")
    (folder / "box" / "meshes" / "lid.OBJ").write_text("new")
    git(folder, "commit", "-a", "-m", "two")
    return folder, first


def unpacked(place, commit, out):
    taken = repository_files.unpack(place, commit, ["box", "nothing"], out)
    return taken, {file.relative_to(out).as_posix(): file.read_text() for file in out.rglob("*") if file.is_file()}


def test_the_named_commit_is_taken(clone, tmp_path):
    folder, first = clone
    assert unpacked(folder, first, tmp_path / "out") == (first, {"box/meshes/lid.OBJ": "old"})


def test_without_that_commit_the_newest_is_taken(clone, tmp_path):
    folder, _ = clone
    assert unpacked(folder, "0" * 40, tmp_path / "out") == (git(folder, "rev-parse", "HEAD"), {"box/meshes/lid.OBJ": "new"})


def test_git_folders_and_archives_do_as_well(clone, tmp_path):
    folder, first = clone
    bare = tmp_path / "bare" / "maker" / "box" / "repo"
    git(tmp_path, "clone", "--bare", str(folder), str(bare))
    place = repository_files.find_repository(tmp_path / "bare", "maker/box")
    assert place == bare and unpacked(place, first, tmp_path / "one")[1] == {"box/meshes/lid.OBJ": "old"}
    (folder / ".git").rename(tmp_path / "git")
    place = repository_files.find_repository(tmp_path / "clones", "maker/box")
    assert place == folder and unpacked(place, first, tmp_path / "two") == ("", {"box/meshes/lid.OBJ": "new"})


def test_files_that_a_git_folder_lacks_are_left_out(clone, tmp_path):
    folder, first = clone
    blob = git(folder, "rev-parse", f"{first}:box/meshes/lid.OBJ")
    (folder / ".git" / "objects" / blob[:2] / blob[2:]).unlink()
    assert unpacked(folder, first, tmp_path / "out") == (first, {})


def test_an_absent_repository_is_none(tmp_path):
    assert repository_files.find_repository(tmp_path, "maker/box") is None
