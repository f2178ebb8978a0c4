"""Names and numbers by which people refer to the bodies and parts of a prediction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from kinmo.core.errors import did_you_mean
from kinmo.core.links import links_of
from kinmo.core.mobility import Mobility
from kinmo.core.overrides import Reference
from kinmo.core.shape import Shape
from kinmo.core.wording import clean_text

MAX_LISTED = 12
"""Largest number of names that a message lists."""
NUMBER_SIGN = "#"
"""Sign before a number in a text, where a number could be a name."""


class ReferenceProblem(Exception):
    """A reference that leads to nothing, or to several things. The message says which, and what to write."""


def find_body(reference: Reference, mobility: Mobility, base: int | None) -> int:
    """Index of the body that a name or a number (its `id`) means.

    A text is the name of a body, the name of its link in a URDF, its number, or its number after #. Without a body of that
    name, `base` is the body of that index.

    Raises:
        ReferenceProblem: there is no such body, or there are several.
    """
    bodies = mobility.bodies
    number_of = {body.id: index for index, body in enumerate(bodies)}
    number = _number(reference)
    marked = isinstance(reference, int) or reference.startswith(NUMBER_SIGN)
    if number is not None and marked and number in number_of:
        return number_of[number]
    if isinstance(reference, int):
        raise ReferenceProblem(f"there is no body {NUMBER_SIGN}{reference}; {_known_bodies(mobility)}")
    named = [index for index, body in enumerate(bodies) if body.name == reference]
    numbered = [] if number is None or number not in number_of else [number_of[number]]
    found = sorted({*named, *numbered})
    if len(found) > 1:
        choices = _either([f'"{NUMBER_SIGN}{bodies[index].id}"' for index in found])
        raise ReferenceProblem(
            f"{len(found)} bodies are called {clean_text(reference)}: write {choices}, their ids in joints.json"
        )
    if found:
        return found[0]
    links = {link.name: base if link.body is None else link.body for link in links_of(mobility)}
    linked = links.get(reference)
    if linked is not None:
        return linked
    near = did_you_mean(reference, [body.name for body in bodies])
    raise ReferenceProblem(f"there is no body {clean_text(reference)}{near}; {_known_bodies(mobility)}")


def find_leaves(reference: Reference, shape: Shape) -> tuple[int, ...]:
    """Leaves of the part that a name or a number (its `id`) means, as indices into `shape.parts`.

    A group stands for all leaves below it.

    Raises:
        ReferenceProblem: there is no such part, or there are several with different leaves.
    """
    number = _number(reference)
    if isinstance(reference, int) or (number is not None and reference.startswith(NUMBER_SIGN)):
        numbered = [index for index, part in enumerate(shape.parts) if part.id == number]
        if not numbered:
            raise ReferenceProblem(f"there is no part {number}; {_known_parts(shape)}")
        return shape.leaves_below[numbered[0]]
    found = [index for index, part in enumerate(shape.parts) if part.name == reference]
    if len({shape.leaves_below[index] for index in found}) > 1:
        choices = _either([str(shape.parts[index].id) for index in found])
        raise ReferenceProblem(
            f"{len(found)} parts are called {clean_text(reference)}: write {choices} without quotes, their ids in joints.json"
        )
    if not found:
        near = did_you_mean(reference, [part.name for part in shape.parts])
        raise ReferenceProblem(f"there is no part {clean_text(reference)}{near}; {_known_parts(shape)}")
    return shape.leaves_below[found[0]]


def body_labels(names: Mapping[int, str]) -> dict[int, str]:
    """Labels of bodies for people, by the number of the body: the name, with the number where the name alone is not enough."""
    count = {name: list(names.values()).count(name) for name in names.values()}
    unclear = {name for name, number in count.items() if number > 1 or not name.strip() or _number(name) is not None}
    return {
        number: f"{clean_text(name)} {NUMBER_SIGN}{number}".strip() if name in unclear else clean_text(name)
        for number, name in names.items()
    }


def _number(reference: Reference) -> int | None:
    if isinstance(reference, int):
        return reference
    digits = reference.removeprefix(NUMBER_SIGN)
    return int(digits) if digits.isascii() and digits.isdigit() and len(digits) < 16 else None


def _known_bodies(mobility: Mobility) -> str:
    return _known(list(body_labels({body.id: body.name for body in mobility.bodies}).values()))


def _known_parts(shape: Shape) -> str:
    names = body_labels({shape.parts[leaf].id: shape.parts[leaf].name for leaf in shape.leaves})
    return _known(list(names.values()))


def _known(names: Sequence[str]) -> str:
    more = "" if len(names) <= MAX_LISTED else f" and {len(names) - MAX_LISTED} more"
    return f"there are {', '.join(names[:MAX_LISTED])}{more}" if names else "there is none"


def _either(choices: Sequence[str]) -> str:
    shown = choices if len(choices) <= MAX_LISTED else [*choices[: MAX_LISTED - 1], "..."]
    return " or ".join([", ".join(shown[:-1]), shown[-1]])
