"""Names of object categories, whatever their spelling.

PartNet-Mobility writes `StorageFurniture` and `Door`, PartNet's trees `storage_furniture` and `door_set`, the paper's tables a
mixture of both. `canonical_category` brings them to the first spelling; a category that it does not know keeps its own. Every
category is the name of a folder sooner or later, and is made to be fit for one.
"""

from __future__ import annotations

import re

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


def _key(name: str) -> str:
    return re.sub(r"[^a-z0-9]", "", name.lower())


_UNFIT = re.compile(r"[/\\\x00-\x1f\x7f]|^\.+$")
LONGEST = 100
"""Characters of a category that are kept."""
_SPELLING = {_key(name): name for name in (*_KNOWN, *_PROCEDURAL)} | _ALIASES


def canonical_category(name: str) -> str:
    """The one spelling of a category: `door_set` and `Door` give `Door`.

    What no folder may be called by is a dash: `pots/pans` gives `pots-pans`, `..` gives `-`.
    """
    return _SPELLING.get(_key(name)) or _UNFIT.sub("-", name[:LONGEST])


def same_category(one: str, other: str) -> bool:
    """Whether two spellings mean the same category."""
    return _key(canonical_category(one)) == _key(canonical_category(other))
