"""Every imported library is a declared dependency."""

from __future__ import annotations

import ast
import re
import sys
from importlib.metadata import packages_distributions
from pathlib import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parents[1]


def declared() -> set[str]:
    """The distributions that kinmo needs, and those of its extras for users."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = (needed for name, needed in project["optional-dependencies"].items() if name not in ("test", "lint"))
    lines = [*project["dependencies"], *(line for needed in extras for line in needed)]
    return {re.split(r"[<>=!~;\[ ]", line, maxsplit=1)[0].lower().replace("_", "-") for line in lines}


def imported() -> dict[str, Path]:
    """Top-level names of all modules that kinmo imports, anywhere in its files, and where."""
    found: dict[str, Path] = {}
    for path in sorted((ROOT / "python" / "kinmo").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and node.module and not node.level:
                names.append(node.module)
            found |= {name.partition(".")[0]: path for name in names}
    return {name: path for name, path in found.items() if name != "kinmo" and name not in sys.stdlib_module_names}


def test_every_module_that_kinmo_imports_is_of_a_declared_dependency() -> None:
    known, modules, provided = declared(), imported(), packages_distributions()
    assert {"numpy", "torch"} <= modules.keys()
    for module, path in modules.items():
        distributions = {name.lower().replace("_", "-") for name in provided.get(module, [module])}
        assert distributions & known, f"{module}, of {sorted(distributions)}, is imported by {path}"
