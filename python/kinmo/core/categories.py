"""One spelling for the names of object categories.

PartNet-Mobility writes `StorageFurniture` and `Door`, PartNet's hierarchies write `storage_furniture` and `door_set`, and the
tables of the paper mix both.
"""

from __future__ import annotations

import re
import unicodedata

KNOWN_CATEGORIES = (
    "Bag", "Bed", "Bottle", "Bowl", "Box", "Bucket", "Camera", "Cart", "Chair", "Clock", "CoffeeMachine", "Dishwasher",
    "Dispenser", "Display", "Door", "Earphone", "Eyeglasses", "Fan", "Faucet", "FoldingChair", "Globe", "Hat", "Kettle",
    "Keyboard", "KitchenPot", "Knife", "Lamp", "Laptop", "Lighter", "Luggage", "Microwave", "Mouse", "Mug", "Oven",
    "Pen", "Phone", "Pliers", "Printer", "Refrigerator", "Remote", "Safe", "Scissors", "Stapler", "StorageFurniture",
    "Suitcase", "Switch", "Table", "Toaster", "Toilet", "TrashCan", "USB", "Vase", "WashingMachine", "Window"
)  # fmt: skip
_PROCEDURAL = ("Clamp", "Mechanism", "Vice")
"""Categories that only procedural shapes have (`kinmo.synth`)."""
_ALIASES = {"doorset": "Door", "cuttinginstrument": "Knife", "garbagecan": "TrashCan", "monitor": "Display"}
_WORD_CHARACTERS = "LMN"
"""Unicode classes that belong to words: letters, marks and digits."""
_WORD_START = re.compile(r"(?<=[^\W\d_])(?=[A-Z][a-z])|(?<=[a-z])(?=[A-Z])")
MAX_CATEGORY_BYTES = 80
"""Longest name of an unknown category, in bytes of UTF-8."""


def _words(name: str) -> list[str]:
    """Lower-case words of a name: `GardenGnome`, `garden_gnome` and `garden gnome` give the same."""
    apart = _WORD_START.sub(" ", unicodedata.normalize("NFKC", name)).lower()
    apart = unicodedata.normalize("NFKC", apart)
    return "".join(letter if unicodedata.category(letter)[0] in _WORD_CHARACTERS else " " for letter in apart).split()


_SPELLING = {"".join(_words(name)): name for name in (*KNOWN_CATEGORIES, *_PROCEDURAL)} | _ALIASES


def canonical_category(name: str) -> str:
    """The one spelling of a category that kinmo uses, which is a valid folder name.

    A known category is spelled as in PartNet-Mobility. Any other gives its lower-case words joined by underscores, as in
    PartNet, and a name without letters and digits gives a dash.

    Example:
        >>> canonical_category("door_set"), canonical_category("GardenGnome")
        ('Door', 'garden_gnome')
    """
    words = _words(name)
    own = "_".join(words).encode()[:MAX_CATEGORY_BYTES].decode(errors="ignore").rstrip("_")
    return _SPELLING.get("".join(words)) or own or "-"


def known_category(name: str) -> str:
    """The canonical spelling of a known category. Empty if the name is none."""
    return _SPELLING.get("".join(_words(name)), "")


def same_category(one: str, other: str) -> bool:
    """True if two spellings mean the same category."""
    return canonical_category(one) == canonical_category(other)
