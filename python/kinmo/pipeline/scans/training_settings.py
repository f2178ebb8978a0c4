"""What networks that see scans are trained on beside the labelled shapes (paper, section 4.2)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, get_args

from kinmo.dataset.shape_dataset import Dataset
from kinmo.dataset.workspace import DEFAULT_METHOD
from kinmo.io.readers import Layout
from kinmo.scans.scan_file import Role

Setting = Literal["supervised", "semi", "semi-weakly", "dsg-net", "ceiling"]
"""Nothing; scans of unlabelled shapes with what networks that were trained so far say of them; shapes with pseudo labels, in
PartNet's layouts (or binary glTF) or in DSG-Net's; shapes whose true labels were held back, which is the best that pseudo
labels could do."""
SETTINGS: tuple[Setting, ...] = get_args(Setting)
PSEUDO_LABELLED: tuple[Setting, ...] = ("semi-weakly", "dsg-net")
"""Networks of these lie in the workspace of the method whose labels they saw, all others in that of the motion networks."""


@dataclass(frozen=True)
class Supplement:
    """What a setting trains on beside the labelled shapes, without which it would be another one.

    In words: the `shapes` that it needs, the scanned `objects` that come of these, and the `remedy` where there are none.
    `count` tells how many such shapes there are; `scanned` are the roles of what is scanned for it, of which held back labels
    tell how right pseudo labels are.
    """

    shapes: str
    objects: str
    remedy: str
    scanned: tuple[Role, ...]
    count: Callable[[Dataset], int]


def _in_dsg_net(dataset: Dataset) -> int:
    return sum(entry.layout == Layout.DSG_NET.value for entry in dataset.unlabelled)


LABELS_NEEDED = (
    "run kinmo pseudo-label, then kinmo render; if that was done, pseudo/acceptance.json says why no label is sure enough"
)
SUPPLEMENTS: Mapping[Setting, Supplement] = {
    "semi": Supplement(
        "without labels",
        "objects that the supervised networks are sure of",
        "lower ancsh.confidence if it is above 0",
        ("unlabelled",),
        lambda dataset: len(dataset.unlabelled),
    ),
    "semi-weakly": Supplement(
        "without labels in PartNet's layouts, or binary glTF",
        "pseudo-labelled objects",
        LABELS_NEEDED,
        ("pseudo", "hidden"),
        lambda dataset: len(dataset.unlabelled) - _in_dsg_net(dataset),
    ),
    "dsg-net": Supplement(
        "in DSG-Net's layout",
        "pseudo-labelled objects in DSG-Net's layout",
        LABELS_NEEDED,
        ("pseudo", "hidden"),
        _in_dsg_net,
    ),
    "ceiling": Supplement(
        "whose labels are held back: kinmo prepare --hold-back keeps some",
        "objects whose labels are held back",
        "run kinmo prepare --hold-back FOLDER, then kinmo render",
        ("hidden",),
        lambda dataset: len(dataset.hidden),
    ),
}


def by_method(title: str, method: str) -> str:
    """What stands for a setting, with the method whose pseudo labels it learnt from, unless that is the default."""
    return title if method == DEFAULT_METHOD else f"{title}, {method}"


def is_pseudo_labelled_for(setting: Setting, layout: str) -> bool:
    """Whether a setting learns from pseudo labels of shapes in a layout."""
    return setting == ("dsg-net" if layout == Layout.DSG_NET.value else "semi-weakly")
