"""Pseudo labels of scanned objects, compared with oracle labels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scanned_objects import cupboard_object

from kinmo.config import ScansConfig
from kinmo.experiments.scan_tables.table_notes import LabelCounts, count_labels
from kinmo.scans.files.scan_file import ScanFile, ScanProvenance, open_scans, write_scans
from kinmo.scans.rendering.labelled_frames import scan_object

TARGET = cupboard_object()


def named(file: ScanFile, name: str, variant: int = 0) -> ScanFile:
    return replace(file, id=name, provenance=ScanProvenance(variant=variant))


def moved(file: ScanFile, part: int, direction: tuple[float, float, float], shift: float) -> ScanFile:
    """The file with another axis of the joint of `part`."""
    joints = list(file.joints)
    joint = joints[part - 1]
    joints[part - 1] = replace(joint, direction=np.array(direction), pivot=joint.pivot + shift)
    return replace(file, joints=tuple(joints))


def test_a_label_is_right_if_all_axes_have_the_true_directions_and_places(tmp_path) -> None:
    scans = scan_object(TARGET, ScansConfig(states=1, views=1, size=64, points=16), 0)
    write_scans(tmp_path / "a.safetensors", TARGET, scans, ScanProvenance())
    file = open_scans(tmp_path / "a.safetensors")
    kinds = [kind.value for kind in file.structure.kinds]
    door, drawer = kinds.index("R") + 1, kinds.index("P") + 1
    up, aside = (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)
    found = {
        "right": file,
        "reversed": moved(file, door, up, 0.0),
        "drawer elsewhere": moved(file, drawer, tuple(file.joints[drawer - 1].direction), 0.3),
        "hinge elsewhere": moved(file, door, up, 0.3),
        "hinge askew": moved(file, door, aside, 0.0),
        "truly another": file,
    }
    true = [named(file, name) for name in found if name != "truly another"] + [named(file, "not labelled")]
    labels = [named(other, name) for name, other in found.items()]
    oracle_ids = {label.object: label.id for label in labels}
    counts = LabelCounts(labelled=6, right_structure=5, right_axes=4, right_lines=3, true=6)
    assert count_labels(labels, true, oracle_ids) == counts
    variants = [named(moved(file, door, aside, 0.0), "right", variant=2)]
    assert count_labels([*labels, *variants], true, oracle_ids) == counts
    more = count_labels([*labels, named(file, "new")], true, oracle_ids)
    assert more == replace(counts, unknown=1)
    assert str(more).endswith("In all, 6 truly have these joints. Another 1 have no oracle labels.")
    alone = count_labels([named(file, "new")], true, oracle_ids)
    assert str(alone) == "Pseudo labels give 1 object these joints; there are no oracle labels for them."
    other = {label.object: f"original of {label.id}" for label in labels}
    renamed = [replace(file, id=f"original of {file.id}") for file in true]
    assert count_labels(labels, renamed, other) == counts, "whatever the id of a copy"
