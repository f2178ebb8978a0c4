"""Documents: links, paths, code blocks and commands are real."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
import typer
from documents import PAGES, ROOT, code_blocks

from kinmo.cli.app import app

PAGE = pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))


@PAGE
def test_every_link_leads_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#\s]+)", page.read_text(encoding="utf-8")):
        if not target.startswith("http"):
            assert (page.parent / target).exists(), f"{target} does not exist"


@PAGE
def test_every_path_in_the_repository_exists(page: Path) -> None:
    for path in re.findall(r"`((?:python|rust|docs|bench|tests|examples)/[\w./-]+)[` ]", page.read_text(encoding="utf-8")):
        assert (ROOT / path).exists(), f"{path} does not exist"


@PAGE
def test_every_command_and_option_exists(page: Path) -> None:
    commands = typer.main.get_command(app).commands  # type: ignore[attr-defined]
    text = page.read_text(encoding="utf-8")
    lines = [line for block in code_blocks(page, "sh") for line in block.splitlines()] + re.findall(r"`(kinmo [^`]+)`", text)
    for line in lines:
        words = shlex.split(line, comments=True)
        if words[:1] != ["kinmo"] or len(words) == 1 or words[1] in ("--version", "COMMAND"):
            continue
        assert words[1] in commands, f"kinmo has no command {words[1]}"
        options = {name for parameter in commands[words[1]].params for name in (*parameter.opts, *parameter.secondary_opts)}
        for word in words[2:]:
            assert not word.startswith("-") or word.split("=")[0] in options, f"kinmo {words[1]} has no option {word}"


def test_every_page_is_in_the_index() -> None:
    index = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    for page in (ROOT / "docs").rglob("*.md"):
        assert page.name == "README.md" or f"({page.relative_to(ROOT / 'docs')})" in index, f"{page} is not in docs/README.md"
