"""Tables of scans on disk: rows, notes, and whether they are up to date."""

from __future__ import annotations

import json
import shutil
from collections import Counter
from dataclasses import fields
from types import SimpleNamespace

import pytest
from scanned_objects import read_frames
from scanned_workspace import CATEGORY, CPU, FAMILY, Scanned, pass_networks_off
from trained_workspace import Recorder

from kinmo.dataset.cache import Cache
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.scan_tables.make_table import MakeTable
from kinmo.experiments.scan_tables.scan_table_layout import NOT_RUN, OUTDATED
from kinmo.experiments.scan_tables.table_rows import TABLES, printed_row
from kinmo.experiments.scan_tables.written_tables import PRINTED_NOTE, WrittenTables
from kinmo.experiments.variant_workspaces import Variant
from kinmo.io.folder_lock import InUse
from kinmo.pipeline.scans.evaluate_scans import EvaluateScans
from kinmo.pipeline.scans.scan_dataset import COMPLETE, open_scan_dataset, scans_folder, training_data
from kinmo.pipeline.scans.scan_networks import NETWORKS, ScanRun
from kinmo.pipeline.scans.scan_scores import PROTOCOLS, ScanScores
from kinmo.pipeline.scans.training_settings import Setting
from kinmo.scans.files.scan_file import count_objects, open_scans, write_scans
from kinmo.scans.object_structure import Structure
from kinmo.scans.rendering.labelled_frames import LabelledFrames


def write(workspace: Workspace, name: str = "2", seeds: tuple[int, ...] = (0,)) -> tuple[list, str]:
    """Write a table. Returns the rows of its means, and its whole text on one line."""
    written = WrittenTables(workspace, name)
    rows = written.write({CATEGORY: seeds}).data[CATEGORY]["means"]["rows"]
    return rows, " ".join((written.folder / CATEGORY / "means.md").read_text(encoding="utf-8").split())


def record_reason(workspace: Workspace, setting: Setting, seed: int, reason: str) -> None:
    ScanScores(workspace, ScanRun(CATEGORY, setting, seed)).record_reason(reason)


def test_tables_and_reasons_are_written_by_one_process_at_a_time(evaluated: Workspace) -> None:
    with evaluated.locked():
        with pytest.raises(InUse):
            write(evaluated)
        with pytest.raises(InUse):
            record_reason(evaluated, "self-training", 0, "of a reason")


def test_a_table_shows_missing_rows_and_printed_figures(scanned: Scanned) -> None:
    EvaluateScans(ScanScores(scanned.workspace, ScanRun(CATEGORY, "supervised", 0)), "cpu").run(Recorder())
    rows, _ = write(scanned.workspace)
    assert int(rows[0][1]) == count_objects(open_scan_dataset(scanned.workspace, CATEGORY).files["train"])
    others = dict.fromkeys(("self-training", "semi-weakly", "semi-weakly, paper", "oracle labels"), NOT_RUN)
    assert {row[0]: row[2] for row in rows} == {"supervised": "0"} | others
    assert printed_row("2", "fridge", "ANCSH") is None
    assert printed_row("2", "refrigerator", "ANCSH")[0] == [12.09, 18.43, 21.7]
    assert printed_row("4", "StorageFurniture", "ANCSH (DSG)")[0] == [40.0, 45.5, 42.0]
    for name, table in TABLES.items():
        for row in table.rows:
            assert not row.printed or all(printed_row(name, category, row.printed) for category in table.categories)


def test_the_summary_is_printed_unless_details_are_asked_for(evaluated: Workspace) -> None:
    texts = [WrittenTables(evaluated, "2", details).write({CATEGORY: [0]}).text for details in (False, True)]
    assert "95 %" not in texts[0] and "95 %" in texts[1]
    assert len(texts[0]) < len(texts[1])


def test_a_table_counts_right_pseudo_labels_where_oracle_labels_are_known(evaluated: Workspace) -> None:
    run = ScanRun(CATEGORY, "semi-weakly", 0)
    assert "Pseudo labels (" not in write(evaluated, seeds=(0, 1))[1]
    pass_networks_off(evaluated, "semi-weakly", 0)
    shutil.copytree(
        scans_folder(evaluated, CATEGORY, "oracle"), scans_folder(evaluated, CATEGORY, "pseudo"), dirs_exist_ok=True
    )
    newer = "Pseudo labels (semi-weakly) are newer than those that the networks were trained on."
    assert newer in write(evaluated, seeds=(0, 1))[1]
    dataset = open_scan_dataset(evaluated, CATEGORY)
    data = training_data(dataset, dataset.extra("semi-weakly"))
    for network in NETWORKS:
        inputs = evaluated.inputs_of(run.stage(network))
        assert inputs is not None
        evaluated.record(run.stage(network), {**inputs, "data": data})
    count = count_objects(dataset.files["oracle"])
    right = (
        f"Of {count} objects that pseudo labels give these joints, {count} truly have them, {count} with the right directions"
    )
    assert right in write(evaluated, seeds=(0, 1))[1]
    pass_networks_off(evaluated, "semi-weakly", 1)
    assert "are newer than those that networks of seeds 1 were trained on." in write(evaluated, seeds=(0, 1))[1]


def test_objects_with_oracle_labels_count_where_pseudo_labels_could_give_their_joints(evaluated: Workspace) -> None:
    pass_networks_off(evaluated, "semi-weakly", 0)
    data = training_data(open_scan_dataset(evaluated, CATEGORY), ())
    for network in NETWORKS:
        inputs = evaluated.inputs_of(ScanRun(CATEGORY, "semi-weakly", 0).stage(network))
        assert inputs is not None and inputs["data"] == data
    _, text = write(evaluated)
    count = count_objects(open_scan_dataset(evaluated, CATEGORY).files["oracle"])
    assert "Of 0 objects that pseudo labels give these joints, 0 truly have them" in text
    assert f"In all, {count} truly have these joints." in text


def test_a_row_covers_all_its_seeds(evaluated: Workspace) -> None:
    def shown() -> tuple[str, str]:
        rows, text = write(evaluated, seeds=(0, 1, 2))
        return str(rows[0][1]), text

    for seed, reason in ((1, "of haste"), (2, "of a reason")):
        record_reason(evaluated, "supervised", seed, reason)
    assert "Not run: supervised: seeds 1: of haste; seeds 2: of a reason." in shown()[1]
    pass_networks_off(evaluated, "supervised", 1)
    trained_on, text = shown()
    assert "Not run: supervised: seeds 2: of a reason." in text
    weights = ScanRun(CATEGORY, "supervised", 1).weights(evaluated)
    assert weights is not None
    header = weights[0].with_suffix(".json")
    facts = json.loads(header.read_text(encoding="utf-8"))
    facts["facts"]["objects"] += 3
    header.write_text(json.dumps(facts), encoding="utf-8")
    assert shown()[0] == f"{trained_on} or {trained_on} + 3"
    evaluated.forget(ScanScores(evaluated, ScanRun(CATEGORY, "supervised", 1)).stage)
    assert "Not run: supervised: seeds 2: of a reason." in shown()[1], "seed 1 is outdated, without a recorded reason"
    assert shown()[0] == trained_on


def test_after_an_interrupted_scanning_no_outdated_figures_are_left(evaluated: Workspace) -> None:
    written = WrittenTables(evaluated, "2")
    folder = written.folder / CATEGORY
    written.write({CATEGORY: [0]})
    assert (folder / "parts.md").exists()
    assert PRINTED_NOTE not in (folder / "means.md").read_text(encoding="utf-8"), "the paper has no pliers"
    Cache(scans_folder(evaluated, CATEGORY, "test")).forget(COMPLETE)
    text = " ".join(written.write({CATEGORY: [0]}).text.split())
    assert "scanning was interrupted: run kinmo render again." in text
    assert {path.stem for path in folder.iterdir()} == {"means", "means_ancsh"}


def test_fewer_seeds_remove_none_from_a_table(evaluated: Workspace, scanned: Scanned) -> None:
    pass_networks_off(evaluated, "supervised", 1)
    stage = MakeTable("2", evaluated, scanned.config, ("kinmo",), FAMILY, 1, hours=0.0, **CPU)  # type: ignore[arg-type]
    rows = stage.run(Recorder()).data[CATEGORY]["means"]["rows"]
    assert {row[0]: row[2] for row in rows}["supervised"] == "0, 1"


def test_rows_name_their_seeds_and_gaps_cover_the_seeds_that_all_have(evaluated: Workspace) -> None:
    for setting, seed in (("supervised", 1), ("semi-weakly", 1), ("oracle", 1), ("oracle", 2)):
        pass_networks_off(evaluated, setting, seed)  # type: ignore[arg-type]
    rows, _ = write(evaluated, seeds=(0, 1, 2))
    assert {row[0]: row[2] for row in rows} == {
        "supervised": "0, 1",
        "self-training": NOT_RUN,
        "semi-weakly": "1",
        "semi-weakly, paper": NOT_RUN,
        "oracle labels": "1, 2",
        "semi-weakly against supervised": "1",
    }
    record_reason(evaluated, "semi-weakly", 2, "of a reason")
    _, text = write(evaluated, seeds=(0, 1, 2))
    assert "seeds 0, 1, 2." in text
    assert "Not run: semi-weakly: seeds 2: of a reason." in text
    shares = "Share of the gap to oracle labels that pseudo labels close"
    assert shares not in text, "the networks of the seed that all have are the same"


def test_by_the_protocol_of_ancsh_there_are_accuracies_too(evaluated: Workspace) -> None:
    found = {protocol: WrittenTables(evaluated, "2").write({CATEGORY: [0]}, protocol).data for protocol in PROTOCOLS}
    columns = {protocol: data[CATEGORY]["parts"]["columns"] for protocol, data in found.items()}
    assert set(columns["ancsh"]) - set(columns["kinmo"]) == {"within 5 deg (%)", "within 5 deg, .05 (%)"}


def test_outdated_scores_are_not_shown(evaluated: Workspace) -> None:
    written = WrittenTables(evaluated, "2")
    assert written.is_current(CATEGORY)
    next(scans_folder(evaluated, CATEGORY, "test").glob("*.safetensors")).unlink()
    assert not written.is_current(CATEGORY)
    rows, _ = write(evaluated)
    assert rows[0][1:] == (None, OUTDATED, *[None] * (len(rows[0]) - 3))
    assert written.is_current(CATEGORY), "it says that its row is outdated"


def test_a_table_shows_the_gain_of_each_training_if_there_are_several(evaluated: Workspace) -> None:
    pass_networks_off(evaluated, "semi-weakly", 0)
    assert "seed by seed" not in write(evaluated, seeds=(0, 1))[1]
    for setting in ("supervised", "semi-weakly"):
        pass_networks_off(evaluated, setting, 1)  # type: ignore[arg-type]
    gains = "semi-weakly against supervised, seed by seed: rotation (deg) +0.00, +0.00; translation +0.000, +0.000;"
    assert gains in write(evaluated, seeds=(0, 1))[1], "the networks are the same"


def test_a_table_counts_test_objects_and_those_with_oracle_labels(evaluated: Workspace) -> None:
    tests = open_dataset(evaluated, CATEGORY).labelled[Split.TEST]
    oracle = sum(entry.is_oracle for entry in tests)
    assert 0 < oracle < len(tests)
    _, text = write(evaluated)
    assert f"labelled training objects, {len(tests)} test objects ({oracle} of them with oracle labels)" in text


def test_a_table_counts_skipped_objects_with_the_reason(evaluated: Workspace) -> None:
    folder = scans_folder(evaluated, CATEGORY, "oracle")
    (first, *_) = sorted(folder.glob("*.safetensors"))
    file = open_scans(first)
    still = SimpleNamespace(
        id="still",
        category=CATEGORY,
        structure=Structure((), ()),
        joints=(),
        part_extents=file.extents,
        axis_aligned_shares=file.axis_aligned_shares,
    )
    write_scans(folder / "still-partnet_mobility.safetensors", still, read_frames(file), file.provenance)
    hinged = SimpleNamespace(**vars(still) | {"id": "unseen", "structure": file.structure, "joints": file.joints})
    scans = read_frames(file)
    none = {field.name: getattr(scans, field.name)[:0] for field in fields(scans) if field.name != "skipped"}
    empty = LabelledFrames(**none, skipped=Counter({"too small": 4}))
    write_scans(folder / "unseen-partnet_mobility.safetensors", hinged, empty, file.provenance)
    cache = Cache(folder)
    for variant in range(3):
        facts = {"reason": "too small", "structure": None, "layout": "partnet_mobility", "variant": variant}
        cache.store(f"tiny-partnet_mobility.{variant}", "", data=facts)
    _, text = write(evaluated)
    assert "skipped with other structures: 1 oracle; " in text
    assert "skipped without a frame that shows all parts: 1 oracle; " in text
    assert "skipped that cannot be scanned (kinmo render says why): 1 oracle" in text


def test_a_table_that_is_written_again_with_nothing_new_leaves_its_files_alone(evaluated: Workspace) -> None:
    def times() -> dict[str, int]:
        files = (path for path in evaluated.path.rglob("*") if path.is_file() and path.name != ".lock")
        return {str(path): path.stat().st_mtime_ns for path in files}

    write(evaluated, seeds=(0, 1))
    before = times()
    write(evaluated, seeds=(0, 1))
    assert times() == before


def test_a_table_is_outdated_once_more_was_evaluated(evaluated: Workspace) -> None:
    written = WrittenTables(evaluated, "2")
    written.write({CATEGORY: [0, 1]})
    assert written.is_current(CATEGORY)
    pass_networks_off(evaluated, "supervised", 1)
    assert not written.is_current(CATEGORY)


def test_scores_on_scans_of_another_structure_are_refused(evaluated: Workspace) -> None:
    row = next(row for row in TABLES["3"].rows if row.variant == Variant(0.3))
    place = row.variant.workspace(evaluated)
    shutil.copytree(evaluated.scans, place.scans)
    assert row.scores(evaluated, CATEGORY, 0).files()
    for path in scans_folder(place, CATEGORY, "train").glob("*.safetensors"):
        file = open_scans(path)
        still = SimpleNamespace(
            id=file.id,
            category=CATEGORY,
            structure=Structure((), ()),
            joints=(),
            part_extents=file.extents,
            axis_aligned_shares=file.axis_aligned_shares,
        )
        write_scans(path, still, read_frames(file), file.provenance)
    with pytest.raises(ValueError, match=r"expected scans of .* like those trained on"):
        row.scores(evaluated, CATEGORY, 0).files()
