"""Files of pseudo labels in a workspace. Nothing here needs torch."""

from __future__ import annotations

from pathlib import Path

from kinmo.core.names import name_on_disk
from kinmo.dataset.store import IndexEntry
from kinmo.dataset.workspace import Workspace
from kinmo.io.readers import PARTNET

LABEL = "mobility_v2.json"  # file with the joints of a pseudo label, in PartNet-Mobility's layout
REPORT = "acceptance.json"  # file of the acceptance report, in the folder of the pseudo labels


def labels_folder(workspace: Workspace, method: str) -> Path:
    """Folder of the pseudo labels of a method."""
    return workspace.pseudo_labels / method


def label_name(entry: IndexEntry) -> str:
    """Name of a shape's folder of pseudo labels: its id, and its layout unless that is PartNet's (ids may clash)."""
    name = name_on_disk(entry.id)
    return name if entry.layout == PARTNET else f"{name}@{entry.layout}"


def stage_of(method: str) -> str:
    """Name of the stage that labels by a method, in records and in the journal."""
    return f"pseudo-label-{method}"
