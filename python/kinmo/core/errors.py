"""Errors that the command line prints in one line."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path

from kinmo.core.wording import clean_text, printable, shortened

MAX_PROBLEM_LENGTH = 600
"""Longest text of a problem, in characters. It may quote a file of any content."""


class KinmoError(Exception):
    """A command cannot do its work. The command line prints the message in one line and exits with 1.

    The texts are cleaned of characters that cannot be printed, and problems of more than `MAX_PROBLEM_LENGTH` are shortened.

    Args:
        where: the file, folder or option that the problem is about.
        problem: what is wrong, what was expected, and what to do.
        field: the field of the file, if the problem is about one.
    """

    def __init__(self, where: Path | str, problem: str, field: str | None = None) -> None:
        self.where = printable(str(where))
        self.field = None if field is None else clean_text(field)
        self.problem = shortened(problem, MAX_PROBLEM_LENGTH)
        place = self.where if self.field is None else f"{self.where}: {self.field}"
        super().__init__(f"{place}: {self.problem}")

    def __reduce__(self) -> tuple[type[KinmoError], tuple[str, str, str | None]]:
        return type(self), (self.where, self.problem, self.field)  # lets worker processes return the error


class InputError(KinmoError, ValueError):
    """A file or value of the user cannot be used. The message names the file, the field, and what was expected."""


def did_you_mean(name: str, known: Iterable[str], least: float = 0.6) -> str:
    """`" (did you mean x?)"` with the known name most similar to an unknown one; empty if none is.

    `least` is the least similarity by difflib, from 0 to 1.
    """
    spelled = {each.lower(): each for each in known}
    near = get_close_matches(name.lower(), spelled, n=1, cutoff=least)
    return f" (did you mean {spelled[near[0]]}?)" if near else ""


@contextmanager
def expecting(what: str, where: Path | str) -> Iterator[None]:
    """Convert errors about the form of the data in file `where` into an InputError that names the expected form `what`.

    Raises:
        InputError: the block raised ValueError, TypeError, KeyError, IndexError or AttributeError.
    """
    try:
        yield
    except InputError:
        raise
    except (ValueError, TypeError, KeyError, IndexError, AttributeError) as error:
        raise InputError(where, f"expected {what} ({type(error).__name__}: {error})") from error
