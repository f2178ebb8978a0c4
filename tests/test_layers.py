"""A module may import from the layers above its own, and from its own, but never from those below."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import kinmo

ROOT = Path(kinmo.__file__).parent

LAYERS = (
    ("_core",),
    (
        "",
        "errors",
        "vector",
        "wording",
        "shape",
        "joint",
        "mobility",
        "box",
        "categories",
        "ground_truth",
        "kinematics",
        "links",
        "frames",
        "normalisation",
        "prediction",
        "splits",
        "config",
        "typed_tables",
        "workers",
    ),
    ("formats",),
    ("synth",),
    ("prepared", "workspace", "store", "prepare", "hypotheses", "evidence"),
    ("scans",),
    ("candidates", "limits"),
    ("learning",),
    ("mobility_tree", "part_geometry", "scoring", "refinement", "type_odds", "ranked_mobility"),
    ("pseudo_label",),
    ("evaluation",),
    ("export",),
    ("report",),
    ("pipeline",),
    ("cli",),
)
"""From top to bottom; "" is the package itself."""
RANK = {name: rank for rank, names in enumerate(LAYERS) for name in names}
WITHOUT_TORCH = (*LAYERS[1], *LAYERS[2], *LAYERS[3], *LAYERS[4], "report", "cli")
FILES = sorted(ROOT.rglob("*.py"))


def top(module: str) -> str:
    """kinmo.learning.graph -> learning."""
    return [*module.split("."), ""][1]


def name_of(file: Path) -> str:
    parts = ("kinmo", *file.relative_to(ROOT).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports(file: Path) -> Iterator[tuple[str, bool]]:
    """Modules that `file` imports, and whether it does so when it is itself imported; those for type checking are left out."""

    def visit(node: ast.AST, at_once: bool) -> Iterator[tuple[str, bool]]:
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            return
        if isinstance(node, ast.Import):
            yield from ((alias.name, at_once) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: a relative import"
            if node.module == "kinmo":
                yield from ((f"kinmo.{a.name}" if top(f"kinmo.{a.name}") in RANK else "kinmo", at_once) for a in node.names)
            elif node.module is not None:
                yield node.module, at_once
        inside = isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
        for child in ast.iter_child_nodes(node):
            yield from visit(child, at_once and not inside)

    yield from visit(ast.parse(file.read_text(encoding="utf-8")), True)


@pytest.mark.parametrize("file", FILES, ids=name_of)
def test_imports_never_reach_down(file: Path) -> None:
    here = top(name_of(file))
    assert here in RANK, f"{name_of(file)} has no place in LAYERS"
    for module, _ in imports(file):
        if module.split(".")[0] == "kinmo":
            assert RANK[top(module)] <= RANK[here], f"{name_of(file)} imports {module}, which is below it"


@pytest.mark.parametrize("file", FILES, ids=name_of)
def test_only_what_learns_imports_torch_at_once(file: Path) -> None:
    if top(name_of(file)) in WITHOUT_TORCH:
        heavy = {"torch", "lightning"} & {module.split(".")[0] for module, at_once in imports(file) if at_once}
        assert not heavy, f"{name_of(file)} imports {heavy}"


def test_readers_know_nothing_of_learning_and_learning_nothing_of_files() -> None:
    for file in FILES:
        here, reached = top(name_of(file)), {top(module) for module, _ in imports(file) if module.startswith("kinmo.")}
        if here in ("formats", "learning"):
            assert not reached & ({"formats", "learning"} - {here}), name_of(file)


def test_a_violation_is_found(tmp_path: Path) -> None:
    file = tmp_path / "sample.py"
    file.write_text("from kinmo import cli\ndef f():\n    import kinmo.report.page, torch\nfrom kinmo.shape import Mesh\n")
    assert list(imports(file)) == [("kinmo.cli", True), ("kinmo.report.page", False), ("torch", False), ("kinmo.shape", True)]


def test_of_the_stages_only_those_of_the_whole_road_know_those_of_scans() -> None:
    knowing = {
        name_of(file)
        for file in ROOT.joinpath("pipeline").glob("*.py")
        if any(module.startswith("kinmo.pipeline.scans") for module, _ in imports(file))
    }
    assert knowing == {f"kinmo.pipeline.{name}" for name in ("train_all", "evaluate_all", "report")}
