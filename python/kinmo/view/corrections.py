"""Corrections that a person makes in a viewer, as the content of overrides.toml (docs/guide/correct.md)."""

from __future__ import annotations

import copy
import os
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from kinmo.api.prediction import Prediction
from kinmo.core.errors import InputError
from kinmo.core.references import ReferenceProblem, find_body
from kinmo.io.atomic_files import write_text_atomically
from kinmo.io.readers.overrides_reader import OVERRIDES_FILE, read_overrides
from kinmo.io.writers.overrides_writer import overrides_text

BACKUP_FILE = "overrides.toml.bak"
"""Copy of an overrides.toml with comments or another order, which saving does not keep."""
_OF_JOINT = ("alternative", "type", "axis", "origin", "range", "flip")
"""Keys that describe the joint of a body."""


@dataclass(eq=False)
class Corrections:
    """Corrections of one prediction. Each change is checked at once, and one that is wrong changes nothing.

    Attributes:
        prediction: the prediction with the present corrections.
        folder: folder of joints.json. None if the prediction was never written.
        table: the content of overrides.toml as plain data.
    """

    prediction: Prediction
    folder: Path | None = None
    table: dict[str, Any] = field(default_factory=dict)
    _text: str | None = None

    @classmethod
    def of(cls, prediction: Prediction, folder: Path | None = None) -> Corrections:
        """Start from the corrections in a folder, or else from those of the prediction.

        Raises:
            InputError: The overrides.toml in the folder is wrong.
        """
        file = None if folder is None else folder / OVERRIDES_FILE
        if file is not None and os.path.lexists(file):
            corrected = prediction.with_overrides(file)
            table = copy.deepcopy(dict(read_overrides(file).table))
            return cls(corrected, folder, table, file.read_text(encoding="utf-8"))
        made = prediction.estimate.correction
        return cls(prediction, folder, {} if made is None else copy.deepcopy(dict(made.overrides)))

    def entry(self, key: str) -> dict[str, Any]:
        """The corrections of a body, by any reference to it. Empty if nothing."""
        name = self._name(key)
        return dict(self.table.get("bodies", {}).get(name, {}))

    def choose(self, key: str, rank: int) -> None:
        """Take the joint of a rank, as joints.json has them; 1 is the best."""
        self._change(key, {"alternative": rank}, _OF_JOINT)

    def set_type(self, key: str, kind: str) -> None:
        """Make the joint a hinge, slider, screw or fixed. The best ranked joint of that type gives axis and range."""
        self._change(key, {"type": kind}, _OF_JOINT)

    def set_range(self, key: str, lower: float, upper: float) -> None:
        """Bound the joint, in degrees for hinges and in lengths of the file for others."""
        self._change(key, {"range": [lower, upper]})

    def set_name(self, key: str, name: str) -> None:
        """Rename the body."""
        self._change(key, {"name": name})

    def flip(self, key: str) -> None:
        """Let the joint open the other way."""
        if self.entry(key).get("flip"):
            self._change(key, {}, ("flip",))
        else:
            self._change(key, {"flip": True})

    def reset(self, key: str) -> None:
        """Remove the corrections of the joint and the name of a body. Its parts and its parent stay."""
        self._change(key, {}, (*_OF_JOINT, "name"))

    @property
    def text(self) -> str:
        """The text of overrides.toml."""
        return overrides_text(self.table)

    def save(self) -> str:
        """Write overrides.toml.

        Returns:
            One line that says what was written.

        Raises:
            InputError: There is no folder, or somebody else changed the file meanwhile.
        """
        if self.folder is None:
            raise InputError(OVERRIDES_FILE, "the prediction has no folder: use Prediction.save first")
        file = self.folder / OVERRIDES_FILE
        there = file.read_text(encoding="utf-8") if os.path.lexists(file) else None
        if there != self._text:
            raise InputError(file, "was changed by somebody else since it was read: start the viewer again")
        kept = ""
        if there is not None and there.strip() and there != overrides_text(read_overrides(file).table):
            write_text_atomically(self.folder / BACKUP_FILE, there)
            kept = f" The old file with its comments is {BACKUP_FILE}."
        write_text_atomically(file, self.text)
        self._text = self.text
        return f"Wrote {file}.{kept} Run kinmo export {self.folder} to write the other files again."

    def _name(self, key: str) -> str:
        """The key of the table of a body: the one that is there, or else `key`."""
        mobility = self.prediction.estimate.predicted.mobility
        wanted = find_body(key, mobility, None)
        for name in self.table.get("bodies", {}):
            with suppress(ReferenceProblem):
                if find_body(name, mobility, None) == wanted:
                    return str(name)
        return key

    def _change(self, key: str, fields: dict[str, Any], removed: tuple[str, ...] = ()) -> None:
        table = copy.deepcopy(self.table)
        bodies = table.setdefault("bodies", {})
        name = self._name(key)
        entry = {each: value for each, value in bodies.get(name, {}).items() if each not in removed}
        bodies[name] = entry = entry | fields
        if not entry:
            del bodies[name]
        if not bodies:
            del table["bodies"]
        self.prediction = self.prediction.with_overrides(table)
        self.table = table
