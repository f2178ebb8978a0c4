"""Scans of a category by their use."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import count
from pathlib import Path

import pytest
from scanned_workspace import CATEGORY, Scanned, with_pseudo_labels
from trained_workspace import Recorder

from kinmo.core.errors import InputError
from kinmo.dataset.cache import Cache
from kinmo.dataset.splits import Split, split_of
from kinmo.dataset.store import PreparedStore, write_index
from kinmo.io.readers import DSG_NET
from kinmo.pipeline.scans.scan_dataset import open_scan_dataset, scans_folder
from kinmo.scans.files.scan_file import ScanFile, count_objects


def test_a_setting_without_labels_of_its_own_cannot_be_trained(scanned: Scanned) -> None:
    problem = "semi-weakly: needs scans of pseudo-labelled objects with 2 parts (revolute on part 0); there are none"
    with pytest.raises(InputError, match=re.escape(f"{problem}: run kinmo pseudo-label, then kinmo render")):
        scanned.train("semi-weakly").plan()


def test_a_category_without_scans_is_named_with_those_that_there_are(scanned: Scanned) -> None:
    with pytest.raises(InputError, match=r"no scans of Plierss \(did you mean Pliers\?\); there are Pliers: run kinmo render"):
        open_scan_dataset(scanned.workspace, "Plierss")


def test_without_validation_objects_some_training_objects_take_their_place(scanned: Scanned, tmp_path: Path) -> None:
    made = scanned.copied(tmp_path)
    made.remove_scans("validation")
    files = open_scan_dataset(made.workspace, CATEGORY).files
    (chosen,) = {file.id for file in files["validation"]}
    assert chosen not in {file.id for role in ("train", "oracle", "unlabelled") for file in files[role]}
    for path in made.scans("train"):
        if not path.name.startswith(f"{chosen}-"):
            path.unlink()
    files = open_scan_dataset(made.workspace, CATEGORY).files
    assert {file.id for file in files["train"]} == {file.id for file in files["validation"]} == {chosen}, "there are no others"


def test_scans_of_copies_of_a_new_test_shape_do_not_count(scanned: Scanned, tmp_path: Path) -> None:
    made, _ = with_pseudo_labels(scanned, tmp_path)
    made.render().run(Recorder())
    before = open_scan_dataset(made.workspace, CATEGORY).files
    entries = PreparedStore(made.workspace.prepared).entries
    tests = (name for name in (f"new-{number}" for number in count()) if split_of(name) is Split.TEST)
    new = []
    for role in ("train", "pseudo", "oracle"):
        (original,) = (entry for entry in entries if (entry.id, entry.layout) == before[role][0].object)
        new.append(replace(original, id=next(tests), layout="partnet_mobility", is_labelled=True, is_oracle=False))
    write_index(made.workspace.prepared, [*entries, *new])
    after = open_scan_dataset(made.workspace, CATEGORY).files
    for role in ("train", "pseudo", "oracle"):
        left = {file.object for file in before[role]} - {before[role][0].object}
        assert {file.object for file in after[role]} <= left, role
        assert len({file.object for file in after[role]}) >= len(left) - 1, "the first oracle object may be the pseudo one"


def test_generated_shapes_are_trained_on_only_without_other_pseudo_labels(scanned: Scanned, tmp_path: Path) -> None:
    made, labels = with_pseudo_labels(scanned, tmp_path, DSG_NET)
    made.render().run(Recorder())
    dataset = open_scan_dataset(made.workspace, CATEGORY)
    assert count_objects(dataset.extra("semi-weakly")) == len(labels)

    def renamed(file: ScanFile) -> ScanFile:
        return replace(file, id=f"{file.id}-copy", provenance=replace(file.provenance, layout="partnet"))

    pseudo = dataset.files["pseudo"]
    both = replace(dataset, files={**dataset.files, "pseudo": (*pseudo, *map(renamed, pseudo[:1]))})
    assert [file.id for file in both.extra("semi-weakly")] == [f"{pseudo[0].id}-copy"]
    assert both.extra("supervised") == both.extra("self-training") == ()
    assert both.extra("oracle") == dataset.files["oracle"]


def test_pseudo_labelled_objects_of_other_structures_are_counted_if_their_layout_is_used(
    scanned: Scanned, tmp_path: Path
) -> None:
    made, _ = with_pseudo_labels(scanned, tmp_path)
    made.render().run(Recorder())
    cache = Cache(scans_folder(made.workspace, CATEGORY, "pseudo"))
    for name, layout, variant in (("one", "partnet", 0), ("two", "partnet", 0), ("two.1", "partnet", 1), ("three", DSG_NET, 0)):
        cache.store(
            name, "", data={"reason": "another structure", "structure": "3 parts", "layout": layout, "variant": variant}
        )
    dataset = open_scan_dataset(made.workspace, CATEGORY)
    assert dataset.count_other_structures() == 2, "there are labels of other shapes than generated ones"
    assert replace(dataset, files={**dataset.files, "pseudo": ()}).count_other_structures() == 3
