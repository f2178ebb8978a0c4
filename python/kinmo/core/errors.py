"""Errors that are told in one line."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path


class KinmoError(Exception):
    """What keeps a command from being done, in one line that names where. The command line prints it and exits with 1."""

    def __init__(self, where: Path | str, problem: str, field: str | None = None) -> None:
        self.where = str(where).encode("utf-8", "backslashreplace").decode("utf-8")
        self.field = field
        self.problem = problem
        place = self.where if field is None else f"{self.where}: {field}"
        super().__init__(" ".join(f"{place}: {problem}".split()))

    def __reduce__(self) -> tuple[type[KinmoError], tuple[str, str, str | None]]:
        return type(self), (self.where, self.problem, self.field)  # it comes out of worker processes


class InputError(KinmoError, ValueError):
    """A file or value given by the user that cannot be used: its text names the file, the field, and what was expected."""


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """What to put after a name that is not among the `known` ones: the nearest of them as a question, if one is near."""
    spelled = {each.lower(): each for each in known}
    near = get_close_matches(name.lower(), spelled, n=1)
    return f" (did you mean {spelled[near[0]]}?)" if near else ""


@contextmanager
def expecting(what: str, where: Path | str) -> Iterator[None]:
    """Turns what goes wrong with data of another form than `what`, read from `where`, into an InputError."""
    try:
        yield
    except InputError:
        raise
    except (ValueError, TypeError, KeyError, IndexError, AttributeError) as error:
        raise InputError(where, f"expected {what} ({type(error).__name__}: {error})") from error
