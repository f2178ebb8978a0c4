"""What Tables 2, 3 and 4 show and say."""

from __future__ import annotations

import json
import shutil
from collections import Counter
from dataclasses import fields
from types import SimpleNamespace

import pytest
from kinmo.pipeline.scans.refusal import REFUSED
from kinmo.pipeline.scans.scored_scans import JudgedScans
from scan_road import CATEGORY, FAMILY, HOW, Scanned, taken_for
from scanned_objects import read_frames
from trained_workspace import Recorder

from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.workspace import StageRecord, Workspace
from kinmo.experiments.scan_tables.make_table import MakeTable
from kinmo.experiments.scan_tables.scan_table_layout import NOT_RUN
from kinmo.experiments.scan_tables.scan_table_layout import OUTDATED as OUTDATED_ROW
from kinmo.experiments.scan_tables.table_rows import TABLES, printed_row
from kinmo.experiments.scan_tables.written_tables import AUTHORS_MEASURE, WrittenTables
from kinmo.io.folder_lock import InUse
from kinmo.pipeline.scans.evaluate_scans import EvaluateScans
from kinmo.pipeline.scans.scan_dataset import open_scan_dataset, scans_of, training_data, unfinished
from kinmo.pipeline.scans.scan_networks import NETWORKS, PROTOCOLS, Cell
from kinmo.pipeline.scans.training_settings import SETTINGS
from kinmo.scans.files.scan_file import count_objects, open_scans, write_scans
from kinmo.scans.object_structure import Structure
from kinmo.scans.rendering.labelled_frames import LabelledFrames


def test_tables_and_reasons_are_written_by_one_process_at_a_time(judged: Workspace) -> None:
    with judged.locked():
        with pytest.raises(InUse):
            WrittenTables(judged, "2").write({CATEGORY: [0]})
        with pytest.raises(InUse):
            JudgedScans(judged, Cell(CATEGORY, "semi", 0)).leave_out("of a reason")


def test_a_table_shows_what_was_not_run_and_the_authors_figures(scanned: Scanned) -> None:
    EvaluateScans(scanned.workspace, Cell(CATEGORY, "supervised", 0), "cpu").run(Recorder())
    found = WrittenTables(scanned.workspace, "2").write({CATEGORY: [0]}).data[CATEGORY]
    run = {row[0]: row[2] for row in found["means"]["rows"]}
    trained = found["means"]["rows"][0][1]
    assert int(trained) == count_objects(open_scan_dataset(scanned.workspace, CATEGORY).files["train"])
    others = dict.fromkeys(("semi", "semi-weakly", "semi-weakly, paper", "true labels"), NOT_RUN)
    assert run == {"supervised": "0"} | others
    assert printed_row("2", "fridge", "ANCSH") is None
    assert printed_row("2", "refrigerator", "ANCSH")[0] == [12.09, 18.43, 21.7]
    assert printed_row("4", "StorageFurniture", "ANCSH (DSG)")[0] == [40.0, 45.5, 42.0]
    for name, table in TABLES.items():
        for row in table.rows:
            assert not row.printed or all(printed_row(name, category, row.printed) for category in table.categories)


def test_a_table_says_how_right_pseudo_labels_are_where_true_ones_are_held_back(judged: Workspace) -> None:
    written, cell = WrittenTables(judged, "2"), Cell(CATEGORY, "semi-weakly", 0)

    def shown() -> str:
        written.write({CATEGORY: [0, 1]})
        return " ".join((written.folder / CATEGORY / "means.md").read_text(encoding="utf-8").split())

    assert "Pseudo labels (" not in shown()
    taken_for(judged, cell.setting, cell.seed)
    hidden, pseudo = (scans_of(judged, CATEGORY, role) for role in ("hidden", "pseudo"))
    shutil.copytree(hidden, pseudo)
    assert "Pseudo labels (semi-weakly) are others now than those that the networks were trained on." in shown()
    dataset = open_scan_dataset(judged, CATEGORY)
    data = training_data(dataset, dataset.beside(cell.setting))
    for network in NETWORKS:
        record = judged.record(cell.stage(network))
        assert record is not None
        judged.write_record(cell.stage(network), StageRecord({**record.inputs, "data": data}))
    count = count_objects(dataset.files["hidden"])
    assert f"Of {count} objects that pseudo labels give these joints {count} truly have them, {count} with all axes" in shown()
    taken_for(judged, cell.setting, 1)
    assert "are others now than those that networks of seeds 1 were trained on." in shown()


def test_held_back_objects_are_counted_where_pseudo_labels_could_tell_their_joints(judged: Workspace) -> None:
    for setting, table in (("semi-weakly", "2"), ("dsg-net", "4")):
        taken_for(judged, setting, 0)  # type: ignore[arg-type]
        text = " ".join(WrittenTables(judged, table).write({CATEGORY: [0]}).text.split())
        own = count_objects(open_scan_dataset(judged, CATEGORY).files["hidden"]) if setting == "semi-weakly" else 0
        assert "Of 0 objects that pseudo labels give these joints 0 truly have them" in text
        assert f"In all, {own} do." in text, "unlabelled shapes are in PartNet's layout"


def test_what_is_told_of_a_row_is_told_of_all_its_seeds(judged: Workspace) -> None:
    def shown() -> tuple[str, str]:
        made = WrittenTables(judged, "2").write({CATEGORY: [0, 1, 2]})
        return str(made.data[CATEGORY]["means"]["rows"][0][1]), " ".join(made.text.split())

    for seed, reason in ((1, "of haste"), (2, "of a reason")):
        JudgedScans(judged, Cell(CATEGORY, "supervised", seed)).leave_out(reason)
    assert "Not run: supervised: seeds 1: of haste; seeds 2: of a reason." in shown()[1]
    taken_for(judged, "supervised", 1)
    trained, text = shown()
    assert "Not run: supervised: seeds 2: of a reason." in text
    weights = Cell(CATEGORY, "supervised", 1).weights(judged)
    assert weights is not None
    header = weights[0].with_suffix(".json")
    facts = json.loads(header.read_text(encoding="utf-8"))
    facts["facts"]["objects"] += 3
    header.write_text(json.dumps(facts), encoding="utf-8")
    assert shown()[0] == f"{trained} or {trained} + 3"
    judged.forget(JudgedScans(judged, Cell(CATEGORY, "supervised", 1)).stage)
    assert "Not run: supervised: seeds 2: of a reason." in shown()[1], "seed 1 is outdated, for no reason that was told"
    assert shown()[0] == trained


def test_where_scanning_was_stopped_no_figures_of_before_are_left_and_no_authors_are_claimed(judged: Workspace) -> None:
    written = WrittenTables(judged, "2")
    folder = written.folder / CATEGORY
    written.write({CATEGORY: [0]})
    assert (folder / "parts.md").exists() and AUTHORS_MEASURE not in (folder / "means.md").read_text(encoding="utf-8")
    unfinished(judged, CATEGORY, "test").touch()
    text = " ".join(written.write({CATEGORY: [0]}).text.split())
    assert "scanning was stopped before all was done: run kinmo render again." in text
    assert {path.stem for path in folder.iterdir()} == {"means", "means_ancsh"}


def test_what_is_left_out_of_a_layout_is_counted_with_the_setting_that_learns_from_it(judged: Workspace) -> None:
    pseudo = scans_of(judged, CATEGORY, "pseudo")
    pseudo.mkdir()
    for name in ("one-partnet", "two-partnet", "two-partnet.1", "three-dsg_net"):
        (pseudo / f"{name}{REFUSED}").touch()
    dataset = open_scan_dataset(judged, CATEGORY)
    assert {setting: dataset.left_out(setting) for setting in SETTINGS} == {
        "supervised": 0,
        "semi": 0,
        "semi-weakly": 2,
        "dsg-net": 1,
        "ceiling": 0,
    }


def test_fewer_seeds_take_none_out_of_a_table(judged: Workspace, scanned: Scanned) -> None:
    taken_for(judged, "supervised", 1)
    found = MakeTable("2", judged, scanned.config, ("kinmo",), FAMILY, 1, hours=0.0, **HOW).run(Recorder())
    assert {row[0]: row[2] for row in found.data[CATEGORY]["means"]["rows"]}["supervised"] == "0, 1"


def test_rows_say_which_seeds_they_are_of_and_gaps_are_over_those_that_all_have(judged: Workspace) -> None:
    for setting, seed in (("supervised", 1), ("semi-weakly", 1), ("ceiling", 1), ("ceiling", 2)):
        taken_for(judged, setting, seed)  # type: ignore[arg-type]
    written = WrittenTables(judged, "2")
    found = written.write({CATEGORY: [0, 1, 2]}).data[CATEGORY]["means"]["rows"]
    assert {row[0]: row[2] for row in found} == {
        "supervised": "0, 1",
        "semi": NOT_RUN,
        "semi-weakly": "1",
        "semi-weakly, paper": NOT_RUN,
        "true labels": "1, 2",
        "semi-weakly against supervised": "1",
    }
    JudgedScans(judged, Cell(CATEGORY, "semi-weakly", 2)).leave_out("of a reason")
    written.write({CATEGORY: [0, 1, 2]})
    text = (written.folder / CATEGORY / "means.md").read_text(encoding="utf-8")
    assert "seeds 0, 1, 2." in text
    assert "Not run: semi-weakly: seeds 2: of a reason." in " ".join(text.split())
    assert "Share of the gap" not in text, "of the seed that all have, all are equal"


def test_by_the_protocol_of_ancsh_parts_have_the_shares_within_five_degrees_too(judged: Workspace) -> None:
    found = {protocol: WrittenTables(judged, "2").write({CATEGORY: [0]}, protocol).data for protocol in PROTOCOLS}
    columns = {protocol: data[CATEGORY]["parts"]["columns"] for protocol, data in found.items()}
    assert set(columns["ancsh"]) - set(columns["kinmo"]) == {"within 5 deg (%)", "within 5 deg, .05 (%)"}


def test_what_was_judged_before_a_change_is_outdated_and_not_shown(judged: Workspace) -> None:
    written = WrittenTables(judged, "2")
    assert written.is_current(CATEGORY)
    test = next(scans_of(judged, CATEGORY, "test").glob("*.safetensors"))
    test.unlink()
    assert not written.is_current(CATEGORY)
    found = written.write({CATEGORY: [0]}).data[CATEGORY]["means"]["rows"]
    assert found[0][1:] == (None, OUTDATED_ROW, *[None] * (len(found[0]) - 3))
    assert written.is_current(CATEGORY), "it says that it is outdated"


def test_a_table_says_what_each_training_has_gained_where_there_are_several(judged: Workspace) -> None:
    def shown() -> str:
        return " ".join(WrittenTables(judged, "2").write({CATEGORY: [0, 1]}).text.split())

    taken_for(judged, "semi-weakly", 0)
    assert "seed by seed" not in shown()
    for setting in ("supervised", "semi-weakly"):
        taken_for(judged, setting, 1)
    told = "semi-weakly against supervised, seed by seed: rotation (deg) +0.00, +0.00; translation +0.000, +0.000;"
    assert told in shown(), "the networks are the same"


def test_a_table_counts_what_it_tests_on_and_how_much_of_that_is_held_back(judged: Workspace) -> None:
    tests = open_dataset(judged, CATEGORY).labelled[Split.TEST]
    held_back = sum(entry.is_held_back for entry in tests)
    assert 0 < held_back < len(tests)
    text = " ".join(WrittenTables(judged, "2").write({CATEGORY: [0]}).text.split())
    assert f"labelled objects to train on, {len(tests)} to test on ({held_back} of them held back)" in text


def test_a_table_counts_objects_of_other_structures_that_no_frame_shows_or_that_have_no_scans(judged: Workspace) -> None:
    (some, *_) = sorted(scans_of(judged, CATEGORY, "hidden").glob("*.safetensors"))
    file = open_scans(some)
    still, unseen = (some.with_name(f"{name}-partnet_mobility.safetensors") for name in ("still", "unseen"))
    base = SimpleNamespace(
        id="still", category=CATEGORY, structure=Structure((), ()), joints=(), part_extents=file.extents, axis_aligned_shares=file.axis_aligned_shares
    )
    write_scans(still, base, read_frames(file), file.provenance)
    hinged = SimpleNamespace(**vars(base) | {"id": "unseen", "structure": file.structure, "joints": file.joints})
    scans = read_frames(file)
    none = {field.name: getattr(scans, field.name)[:0] for field in fields(scans) if field.name != "skipped"}
    write_scans(unseen, hinged, LabelledFrames(**none, skipped=Counter({"too small": 4})), file.provenance)
    for variant in ("", ".1", ".2"):
        some.with_name(f"tiny-partnet_mobility{variant}{REFUSED}").touch()
    text = " ".join(WrittenTables(judged, "2").write({CATEGORY: [0]}).text.split())
    assert "of other structures: 1 held back; " in text
    assert "that no frame shows all parts of: 1 held back; " in text
    assert "that cannot be scanned (kinmo render says why): 1 held back" in text


def test_a_table_that_is_written_again_with_nothing_new_leaves_its_files_alone(judged: Workspace) -> None:
    WrittenTables(judged, "2").write({CATEGORY: [0, 1]})
    places = judged.path / "eval", judged.path / "records"
    times = {path: path.stat().st_mtime_ns for place in places for path in place.rglob("*") if path.is_file()}
    WrittenTables(judged, "2").write({CATEGORY: [0, 1]})
    assert {path: path.stat().st_mtime_ns for path in times} == times


def test_a_table_is_outdated_once_more_was_judged(judged: Workspace) -> None:
    written = WrittenTables(judged, "2")
    written.write({CATEGORY: [0, 1]})
    assert written.is_current(CATEGORY)
    taken_for(judged, "supervised", 1)
    assert not written.is_current(CATEGORY)
