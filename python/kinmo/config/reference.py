"""Reference page of the configuration: every field with its type, its values and its description.

`python -m kinmo.config.reference` prints the page. docs/reference/config.md is a copy of it, which the tests compare.
"""

from __future__ import annotations

import ast
import inspect
import sys
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from textwrap import dedent
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

from kinmo.config.config import Config
from kinmo.config.loading import builtin_configs, load_config
from kinmo.core.typed_tables import Within

HEAD = """# Configuration

`--config` takes `small` (two CPU cores, the default), `paper` (the paper's sizes, for a GPU), or the path of a TOML file. A file that
begins with `extends = "small"` only says what differs:

```toml
extends = "small"

[ranking]
members = 5

[ranking.training]
epochs = 30
```

Unknown keys and wrong values are errors that name the file and the key. This page is generated: `python -m kinmo.config.reference`.
"""


def reference_page() -> str:
    """The page as Markdown."""
    configs = {name: load_config(name) for name in builtin_configs()}
    return "\n".join([HEAD, *_sections(Config, "", configs)])


def _sections(kind: type, path: str, configs: dict[str, Any]) -> Iterator[str]:
    """One table for the fields of a section, followed by those of its subsections."""
    texts, hints = field_descriptions(kind), get_type_hints(kind, include_extras=True)
    rows = []
    subsections = []
    for each in fields(kind):
        hint = hints[each.name]
        if is_dataclass(hint) and isinstance(hint, type):
            subsections.append((each.name, hint))
            continue
        values = [_shown(getattr(config, each.name)) for config in configs.values()]
        rows.append(f"| `{each.name}` | {_type_name(hint)} | {' | '.join(values)} | {texts[each.name]} |")
    if path:
        yield f"## [{path}]\n\n{inspect.cleandoc(kind.__doc__ or '')}\n"
        if rows:
            yield f"| key | type | {' | '.join(configs)} | meaning |"
            yield "|" + "---|" * (3 + len(configs))
            yield from rows
            yield ""
    for name, hint in subsections:
        inner = {known: getattr(config, name) for known, config in configs.items()}
        yield from _sections(hint, f"{path}.{name}" if path else name, inner)


def field_descriptions(kind: type) -> dict[str, str]:
    """Description of each field of a dataclass: the string literal below it.

    Args:
        kind: the dataclass.

    Returns:
        Descriptions by name of the field, in one line each. Fields without a description are missing.
    """
    (definition,) = ast.parse(dedent(inspect.getsource(kind))).body
    assert isinstance(definition, ast.ClassDef)
    texts = {}
    for field, text in zip(definition.body, definition.body[1:], strict=False):
        is_text = isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant) and isinstance(text.value.value, str)
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and is_text:
            texts[field.target.id] = " ".join(text.value.value.split())  # type: ignore[attr-defined]
    return texts


def _type_name(hint: Any) -> str:
    """Type of a field in words: `integer`, `number from 0 to 1`, or its values."""
    if get_origin(hint) is Annotated:
        inner, within = get_args(hint)
        assert isinstance(within, Within)
        if get_origin(inner) is tuple:
            return _type_name(inner)
        high = "" if within.high >= 1e9 else f" to {within.high:g}"
        low = "above 0" if within.low == sys.float_info.min else f"from {within.low:g}"
        return f"{_type_name(inner)} {low}{high}"
    if get_origin(hint) is Literal:
        return ", ".join(f'`"{value}"`' for value in get_args(hint))
    if get_origin(hint) is tuple:
        return f"list of {_type_name(get_args(hint)[0])}"
    return {int: "integer", float: "number", bool: "true or false", str: "text"}[hint]


def _shown(value: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    return f"[{', '.join(map(_shown, value))}]" if isinstance(value, tuple) else f"{value:g}"


if __name__ == "__main__":
    print(reference_page(), end="")
