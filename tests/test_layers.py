"""The layers of the package: a module imports only from its own package and from those above it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import kinmo

ROOT = Path(kinmo.__file__).parent

LAYERS = (
    ("_core",),
    ("core", "config"),
    ("robot",),
    ("io",),
    ("features",),
    ("learning",),
    ("methods",),
    ("scans",),
    ("dataset",),
    ("evaluation",),
    ("pipeline",),
    ("api", ""),
    ("experiments",),
    ("synth",),
    ("view",),
    ("cli",),
)
"""Layers from top to bottom; "" is the package itself, which offers the public API."""
RANK = {name: rank for rank, names in enumerate(LAYERS) for name in names}
WITHOUT_TORCH = ("core", "config", "robot", "io", "features", "dataset", "synth", "view", "cli", "")
"""Packages that must be imported fast."""
APART = ("methods.paper", "methods.kinmo")
"""Packages that never import each other."""
FILES = sorted(ROOT.rglob("*.py"))


def package_of(module: str) -> str:
    """First name below kinmo: `learning` for kinmo.learning.network_layers, "" for kinmo."""
    return [*module.split("."), ""][1]


def name_of(file: Path) -> str:
    parts = ("kinmo", *file.relative_to(ROOT).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports(file: Path) -> Iterator[tuple[str, bool]]:
    """Modules that `file` imports, and True for those imported along with it; imports for type checking are left out."""

    def visit(node: ast.AST, at_once: bool) -> Iterator[tuple[str, bool]]:
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            return
        if isinstance(node, ast.Import):
            yield from ((alias.name, at_once) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: a relative import"
            if node.module == "kinmo":
                names = (f"kinmo.{alias.name}" for alias in node.names)
                yield from ((name if package_of(name) in RANK else "kinmo", at_once) for name in names)
            elif node.module is not None:
                yield node.module, at_once
        inside = isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
        for child in ast.iter_child_nodes(node):
            yield from visit(child, at_once and not inside)

    yield from visit(ast.parse(file.read_text(encoding="utf-8")), True)


@pytest.mark.parametrize("file", FILES, ids=name_of)
def test_a_module_imports_only_from_its_layer_and_those_above(file: Path) -> None:
    here = package_of(name_of(file))
    assert here in RANK, f"{name_of(file)} has no place in LAYERS"
    for module, _ in imports(file):
        if module.split(".")[0] == "kinmo":
            assert RANK[package_of(module)] <= RANK[here], f"{name_of(file)} imports {module}, which is below it"


@pytest.mark.parametrize("file", FILES, ids=name_of)
def test_packages_without_networks_do_not_import_torch_at_once(file: Path) -> None:
    if package_of(name_of(file)) in WITHOUT_TORCH:
        heavy = {"torch"} & {module.split(".")[0] for module, at_once in imports(file) if at_once}
        assert not heavy, f"{name_of(file)} imports {heavy}"


def test_the_two_methods_do_not_know_each_other() -> None:
    for file in FILES:
        for one, other in (APART, APART[::-1]):
            if name_of(file).startswith(f"kinmo.{one}"):
                assert not [module for module, _ in imports(file) if module.startswith(f"kinmo.{other}")], name_of(file)


def test_few_modules_lie_directly_in_the_package() -> None:
    assert len(list(ROOT.glob("*.py"))) <= 4


def test_a_violation_is_found(tmp_path: Path) -> None:
    file = tmp_path / "sample.py"
    file.write_text("from kinmo import cli\ndef f():\n    import kinmo.view.page, torch\nfrom kinmo.core.shape import Mesh\n")
    found = [("kinmo.cli", True), ("kinmo.view.page", False), ("torch", False), ("kinmo.core.shape", True)]
    assert list(imports(file)) == found
