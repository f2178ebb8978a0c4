"""What the README and docs/ say is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from typer.main import get_command

from kinmo.cli.app import app

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
COMMANDS = get_command(app).commands  # type: ignore[attr-defined]


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_lead_to_files_that_are_there(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#\s]+)", page.read_text(encoding="utf-8")):
        if "://" not in target:
            assert (page.parent / target).exists(), f"{name_of(page)} links to {target}"


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_commands_and_their_options_exist(page: Path) -> None:
    for command, rest in re.findall(r"^ {4}kinmo (\S+)([^\n]*)", page.read_text(encoding="utf-8"), re.MULTILINE):
        assert command in COMMANDS, f"{name_of(page)} names kinmo {command}"
        known = {option for parameter in COMMANDS[command].params for option in parameter.opts}
        for option in re.findall(r"(?<=\s)--?[a-z][a-z-]*", rest.split("#")[0]):
            assert option in known, f"{name_of(page)} names kinmo {command} {option}"


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_modules_named_exist(page: Path) -> None:
    for module in re.findall(r"`((?:rust|python|docs|tests|bench)/[\w/.-]+)`", page.read_text(encoding="utf-8")):
        assert (ROOT / module).exists(), f"{name_of(page)} names {module}"


def test_every_page_of_the_documentation_is_in_its_index() -> None:
    index = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    for page in PAGES:
        if page.parent.name == "docs" and page.name != "README.md":
            assert f"({page.name})" in index
