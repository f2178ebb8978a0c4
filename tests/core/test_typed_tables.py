"""Typed tables: dataclasses from TOML and JSON."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import pytest

from kinmo.core.errors import InputError
from kinmo.core.typed_tables import Within, from_table, to_table


@dataclass(frozen=True)
class Encoder:
    widths: Annotated[tuple[Annotated[int, Within(1, 9)], ...], Within(1, 3)]
    norm: Literal["batch", "none"] = "batch"


@dataclass(frozen=True)
class Network:
    encoder: Encoder
    rate: Annotated[float, Within(0.0)] = 1.0
    seed: int | None = None


TABLE: dict[str, Any] = {"encoder": {"widths": [1, 2], "norm": "none"}, "rate": 2, "seed": None}


def test_a_table_survives_a_round_trip() -> None:
    network = from_table(Network, TABLE, "a.toml")
    assert network == Network(Encoder((1, 2), "none"), 2.0, None)
    assert isinstance(network.rate, float)
    assert to_table(network) == TABLE


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({}, "encoder: missing"),
        ({"encoder": 3}, "encoder: expected a table"),
        ({"encoder": {"width": [1]}}, "encoder.width: unknown key (did you mean widths?); expected one of widths, norm"),
        ({"encoder": {"widths": [1, "2"]}}, "encoder.widths[1]: expected int, got '2'"),
        ({"encoder": {"widths": [1, True]}}, "encoder.widths[1]: expected int, got True"),
        ({"encoder": {"widths": [10]}}, "encoder.widths[0]: expected a number of 1 to 9, got 10"),
        ({"encoder": {"widths": []}}, "encoder.widths: expected a list with a length of 1 to 3, got []"),
        ({"encoder": {"widths": 7}}, "encoder.widths: expected a list, got 7"),
        ({"encoder": {"widths": [1], "norm": "mine"}}, "encoder.norm: expected one of batch, none, got 'mine'"),
        ({**TABLE, "rate": -1}, "rate: expected a number of at least 0, got -1"),
        ({**TABLE, "seed": 1.5}, "seed: expected int, got 1.5"),
    ],
)
def test_a_mistake_names_file_field_and_expectation(table: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=f"^a.toml: {re.escape(message)}$"):
        from_table(Network, table, "a.toml")
