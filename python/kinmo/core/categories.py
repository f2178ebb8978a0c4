"""Names of object categories, whatever their spelling.

PartNet-Mobility writes `StorageFurniture` and `Door`, PartNet's trees `storage_furniture` and `door_set`, the paper's tables a
mixture of both. `canonical_category` brings them to the first spelling, and a category that it does not know to that of
PartNet's trees: lower case, words joined by underscores. Every category is the name of a folder sooner or later, and is fit
for one.
"""

from __future__ import annotations

import re
import unicodedata

_KNOWN = (
    "Bag", "Bed", "Bottle", "Bowl", "Box", "Bucket", "Camera", "Cart", "Chair", "Clock", "CoffeeMachine", "Dishwasher",
    "Dispenser", "Display", "Door", "Earphone", "Eyeglasses", "Fan", "Faucet", "FoldingChair", "Globe", "Hat", "Kettle",
    "Keyboard", "KitchenPot", "Knife", "Lamp", "Laptop", "Lighter", "Luggage", "Microwave", "Mouse", "Mug", "Oven",
    "Pen", "Phone", "Pliers", "Printer", "Refrigerator", "Remote", "Safe", "Scissors", "Stapler", "StorageFurniture",
    "Suitcase", "Switch", "Table", "Toaster", "Toilet", "TrashCan", "USB", "Vase", "WashingMachine", "Window"
)  # fmt: skip
_PROCEDURAL = ("Clamp", "Mechanism", "Vice")
"""Of procedural shapes alone (`kinmo.synth`)."""
_ALIASES = {"doorset": "Door", "cuttinginstrument": "Knife", "garbagecan": "TrashCan", "monitor": "Display"}
_OF_WORDS = "LMN"
"""Letters, the marks on them, and digits."""
_NEXT_WORD = re.compile(r"(?<=[^\W\d_])(?=[A-Z][a-z])|(?<=[a-z])(?=[A-Z])")
LONGEST = 80
"""Bytes of an unknown category that are kept, in UTF-8."""


def _words(name: str) -> list[str]:
    """In lower case; `GardenGnome`, `garden_gnome` and `garden gnome` have the same."""
    apart = _NEXT_WORD.sub(" ", unicodedata.normalize("NFKC", name)).lower()
    apart = unicodedata.normalize("NFKC", apart)
    return "".join(letter if unicodedata.category(letter)[0] in _OF_WORDS else " " for letter in apart).split()


def _key(name: str) -> str:
    return "".join(_words(name))


_SPELLING = {_key(name): name for name in (*_KNOWN, *_PROCEDURAL)} | _ALIASES


def canonical_category(name: str) -> str:
    """The one spelling of a category: `door_set` and `Door` give `Door`, `GardenGnome`, which is not known, `garden_gnome`.

    What has no letter and no digit is a dash.
    """
    words = _words(name)
    own = "_".join(words).encode()[:LONGEST].decode(errors="ignore").rstrip("_")
    return _SPELLING.get("".join(words)) or own or "-"


def same_category(one: str, other: str) -> bool:
    """Whether two spellings mean the same category."""
    return canonical_category(one) == canonical_category(other)
