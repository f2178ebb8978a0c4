"""Labels that networks for scans learn from besides those of the labelled shapes (paper, section 4.2)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, get_args

from kinmo.dataset.shape_dataset import ShapeDataset
from kinmo.scans.files.scan_file import Role

Setting = Literal["supervised", "self-training", "semi-weakly", "oracle"]
"""`supervised`: no other labels. `self-training`: the supervised networks label scans of unlabelled shapes. `semi-weakly`:
pseudo labels of unlabelled shapes. `oracle`: oracle labels, the upper bound of what pseudo labels can give."""
SETTINGS: tuple[Setting, ...] = get_args(Setting)


@dataclass(frozen=True)
class ExtraLabels:
    """Labels that a setting needs besides those of the labelled shapes."""

    shapes: str  # the shapes that it needs, in words
    objects: str  # the scanned objects that it needs, in words
    remedy: str  # what to do where there are none
    roles: tuple[Role, ...]  # of the objects that are scanned for it; oracle labels measure how right pseudo labels are
    count: Callable[[ShapeDataset], int]  # number of shapes of a dataset that it can use


EXTRA_LABELS: Mapping[Setting, ExtraLabels] = {
    "self-training": ExtraLabels(
        "without labels",
        "objects that the supervised networks are sure of",
        "run kinmo train ancsh --setting self-training, or lower ancsh.confidence if it is above 0",
        ("unlabelled",),
        lambda dataset: len(dataset.unlabelled),
    ),
    "semi-weakly": ExtraLabels(
        "without labels",
        "pseudo-labelled objects",
        "run kinmo pseudo-label, then kinmo render; acceptance.json beside the pseudo labels says why shapes were refused",
        ("pseudo", "oracle"),
        lambda dataset: len(dataset.unlabelled),
    ),
    "oracle": ExtraLabels(
        "with oracle labels: kinmo prepare --oracle names some",
        "objects with oracle labels",
        "run kinmo prepare --oracle FOLDER, then kinmo render",
        ("oracle",),
        lambda dataset: len(dataset.oracle),
    ),
}
