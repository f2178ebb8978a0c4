"""The families: one module each, with `build(draw) -> SynthObject`. A family is named after its module.

A family draws everything from `draw`, builds every part in the pose of joint value 0 (mostly closed), and gives joints a `rest`
where the file shall show them open. Size, place, node ids and the quirks of real files are added afterwards.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from kinmo.core.errors import InputError, did_you_mean
from kinmo.synth.draw import Draw
from kinmo.synth.model import SynthObject

Build = Callable[[Draw], SynthObject]


@cache
def family_names() -> tuple[str, ...]:
    """All families, in alphabetical order."""
    return tuple(sorted(module.name for module in iter_modules(__path__)))


def family(name: str) -> Build:
    """The builder of a family; InputError for an unknown name."""
    if name not in family_names():
        near = did_you_mean(name, family_names())
        raise InputError("family", f"unknown family {name!r}{near}, expected some of {', '.join(family_names())}")
    build: Build = import_module(f"{__name__}.{name}").build
    return build
