"""Object families: one module each, with a function `build(draw) -> SynthObject`. A family is named after its module.

To add a family, add one module to this folder. Nothing needs to be registered: `family_names` lists the modules, and the tests
of all families find the new one. A test file in tests/synth/families checks what is special about it. Rules for `build`:

- Take every random value from `draw`. A seed then decides the shape.
- Build each part in the pose of joint value 0, mostly closed. A `rest` value shows a joint open in the file.
- Use y up, +z to the front, and any length unit. Size, position, node ids and the quirks of real files come afterwards.
- Every leaf needs geometry and exactly one link (`SynthObject.check`).
- Spell `category` as `kinmo.core.categories.canonical_category` does. The root node may have any spelling of it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from kinmo.core.errors import InputError, did_you_mean
from kinmo.synth.draw import Draw
from kinmo.synth.synth_object import SynthObject

FamilyBuilder = Callable[[Draw], SynthObject]
"""Function that builds one object of a family."""


@cache
def family_names() -> tuple[str, ...]:
    """Names of all families, in alphabetical order."""
    return tuple(sorted(module.name for module in iter_modules(__path__)))


def family_builder(name: str) -> FamilyBuilder:
    """The `build` function of a family.

    Args:
        name: One of `family_names()`.

    Returns:
        A function that takes a `Draw` and gives an object in the family's own size and frame.

    Raises:
        InputError: There is no family of that name.
    """
    if name not in family_names():
        near = did_you_mean(name, family_names())
        raise InputError("--family", f"unknown family {name!r}{near}, expected some of {', '.join(family_names())}")
    build: FamilyBuilder = import_module(f"{__name__}.{name}").build
    return build
