"""Libraries that only some formats need, imported when a file needs them."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from types import ModuleType

from kinmo.core.errors import InputError


def optional_library(module: str, extra: str, where: Path | str, what: str, use: str = "read it") -> ModuleType:
    """Import a library of one of kinmo's extras.

    Args:
        module: name of the module.
        extra: extra of kinmo that has the library, such as "formats".
        where: the file that needs it.
        what: what the file has that needs it, such as "meshes compressed with Draco".
        use: what the library is for.

    Raises:
        InputError: the library is not installed. The message says how to install it.
    """
    try:
        return import_module(module)
    except ImportError:
        raise InputError(where, f"{what}: pip install 'kinmo[{extra}]' to {use}") from None
