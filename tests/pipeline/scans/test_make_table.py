"""The tables of networks that see scans: what they show, and what they say of what is not there."""

from __future__ import annotations

import json
import re
import shutil
from collections import Counter
from dataclasses import fields, replace
from pathlib import Path
from types import SimpleNamespace

import pytest
from scan_road import CATEGORY, FAMILY, HOW, Scanned
from whole_road import Listener

from kinmo.errors import InputError
from kinmo.evaluation.scan_tables import NOT_RUN
from kinmo.evaluation.scan_tables import OUTDATED as OUTDATED_ROW
from kinmo.pipeline.dataset import open_dataset
from kinmo.pipeline.evaluate import Evaluate
from kinmo.pipeline.evaluate_all import EvaluateAll
from kinmo.pipeline.prepare import Prepare
from kinmo.pipeline.report import Report
from kinmo.pipeline.scans.dataset import open_scan_dataset, scans_of, training_data
from kinmo.pipeline.scans.evaluate import EvaluateScans
from kinmo.pipeline.scans.judge_trained import JudgeTrained
from kinmo.pipeline.scans.judged import JudgedScans
from kinmo.pipeline.scans.make_table import TOO_LONG, MakeTable
from kinmo.pipeline.scans.networks import NETWORKS, PROTOCOLS, Cell
from kinmo.pipeline.scans.pictures import COMMON
from kinmo.pipeline.scans.refusal import REFUSED
from kinmo.pipeline.scans.report import OUTDATED, picture_sections
from kinmo.pipeline.scans.settings import SETTINGS, Setting
from kinmo.pipeline.scans.table_rows import TABLES, printed_row
from kinmo.pipeline.scans.train import TrainAncsh
from kinmo.pipeline.scans.written_tables import WrittenTables
from kinmo.pipeline.synth import Synth
from kinmo.scans.articulated_object import Structure
from kinmo.scans.scan import Scans
from kinmo.scans.scan_file import count_objects, open_scans, write_scans
from kinmo.splits import Split
from kinmo.workspace import InUse, StageRecord, Workspace


def test_a_cell_that_cannot_be_run_leaves_the_others(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    shutil.rmtree(tmp_path / "workspace" / "eval", ignore_errors=True)  # of other tests
    told = Listener()
    stage = MakeTable("4", Workspace(tmp_path / "workspace"), scanned.config, ("kinmo",), FAMILY, 1, **HOW)
    assert stage.plan().steps == (f"{CATEGORY}, supervised, seed 0: judge",), "the other has nothing to learn from"
    found = stage.run(told)
    assert found.failed == 1
    assert [note for note in told.notes if note.startswith(f"not run: {CATEGORY}, generated shapes") and "DSG-Net" in note]
    run = {row[0]: row[1] for row in found.data[CATEGORY]["parts"]["rows"]}
    assert run == {"supervised": "1", "generated shapes": "not run", "generated shapes, paper": "not run"}
    assert "Not run: generated shapes: no shapes of Laptop in DSG-Net's layout." in found.text
    assert "Not run: generated" in WrittenTables(stage.workspace, "4").write({CATEGORY: [0]}).text, "whoever writes it again"


def test_where_another_process_is_writing_it_is_said_once_and_no_table_is_written(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    shutil.rmtree(tmp_path / "workspace" / "eval", ignore_errors=True)
    workspace, told = Workspace(tmp_path / "workspace"), Listener()
    for stage in (MakeTable("4", workspace, scanned.config, ("kinmo",), FAMILY, 1, **HOW), JudgeTrained(workspace, FAMILY)):
        with workspace.locked(), pytest.raises(InUse, match="is writing here"):
            stage.run(told)
    assert not [note for note in told.notes if note.startswith("not ")]
    assert not workspace.evaluation.exists()


def test_tables_and_reasons_are_written_by_one_process_at_a_time(judged: Workspace) -> None:
    with judged.locked():
        with pytest.raises(InUse):
            WrittenTables(judged, "2").write({CATEGORY: [0]})
        with pytest.raises(InUse):
            JudgedScans(judged, Cell(CATEGORY, "semi", 0)).leave_out("of a reason")


def test_without_labels_that_are_held_back_the_row_of_true_ones_is_no_failure(tmp_path: Path) -> None:
    Synth(tmp_path / "partnet", 2, (FAMILY,), ("partnet_mobility",)).run(Listener())
    workspace, told = Workspace(tmp_path / "workspace"), Listener()
    Prepare(tmp_path / "partnet", workspace).run(Listener())
    stage = MakeTable("2", workspace, "small", ("kinmo",), FAMILY, 1, hours=0.0, **HOW)
    assert [step.split(":")[0] for step in stage.plan().steps] == [f"{CATEGORY}, supervised, seed 0"]
    found = stage.run(told)
    assert found.failed == 2, "semi and semi-weakly: there is nothing without labels"
    assert [note for note in told.notes if "true labels" in note and "kinmo prepare --hold-back" in note]
    assert "Not run: true labels: no shapes of Laptop whose labels are held back" in found.text
    Synth(tmp_path / "partnet", 3, (FAMILY,), ("partnet_mobility",)).run(Listener())
    Prepare(tmp_path / "partnet", workspace).run(Listener())
    text = " ".join(WrittenTables(workspace, "2").write({CATEGORY: [0]}).text.split())
    assert "whose labels are held back" not in text, "other shapes may change that"


def test_without_motion_networks_the_tables_of_scans_are_there_alone(scanned: Scanned) -> None:
    shapes = Evaluate(scanned.workspace, ("kinmo", "paper"), FAMILY)
    stage, told = EvaluateAll(shapes, JudgeTrained(scanned.workspace, FAMILY, device="cpu")), Listener()
    found = stage.run(told)
    assert list(found.data) == ["table-2"]
    assert [note for note in told.notes if note.startswith("no Table 1:")]


def test_a_table_shows_what_was_not_run_and_the_authors_figures(scanned: Scanned) -> None:
    EvaluateScans(scanned.workspace, Cell(CATEGORY, "supervised", 0), "cpu").run(Listener())
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


def taken_for(workspace: Workspace, setting: Setting, seed: int) -> None:
    """Take the trained networks for those of another setting and seed, and judge them."""
    known, wanted = Cell(CATEGORY, "supervised", 0), Cell(CATEGORY, setting, seed)
    for network in NETWORKS:
        shutil.copytree(known.folder(workspace, network), wanted.folder(workspace, network))
        record = workspace.record(known.stage(network))
        assert record is not None
        workspace.write_record(wanted.stage(network), StageRecord(record.inputs))
    EvaluateScans(workspace, wanted, "cpu").run(Listener())


@pytest.fixture
def judged(scanned: Scanned, tmp_path: Path) -> Workspace:
    """A workspace of one's own, whose supervised networks are judged."""
    JudgeTrained(scanned.workspace, FAMILY, device="cpu").run(Listener())
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    return Workspace(tmp_path / "workspace")


def test_a_table_says_how_right_pseudo_labels_are_where_true_ones_are_held_back(judged: Workspace) -> None:
    written, cell = WrittenTables(judged, "2"), Cell(CATEGORY, "semi-weakly", 0)

    def shown() -> str:
        written.write({CATEGORY: [0]})
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
    found = MakeTable("2", judged, scanned.config, ("kinmo",), FAMILY, 1, hours=0.0, **HOW).run(Listener())
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
    assert "Not run: semi-weakly: seeds 0, 2: of a reason." in " ".join(text.split())
    assert "Share of the gap" not in text, "of the seed that all have, all are equal"


def test_of_a_category_of_the_paper_its_tables_are_shown_with_their_figures_before_anything_is_trained(tmp_path: Path) -> None:
    Synth(tmp_path / "partnet", 2, ("scissors",), ("partnet_mobility",)).run(Listener())
    workspace = Workspace(tmp_path / "workspace")
    Prepare(tmp_path / "partnet", workspace).run(Listener())
    found = JudgeTrained(workspace, "scissors", device="cpu").run(Listener())
    assert set(found.data) == {"table-2", "table-3"}
    for table, rows in (("2", ["ANCSH", "ANCSH (Semi)", "ANCSH (Semi-weakly)"]), ("3", ["Semi-weakly (30%)"])):
        (shown,) = found.data[f"table-{table}"].values()
        titles = shown["parts"]["columns"]
        turned = [row[titles.index("rotation (deg)")] for row in shown["parts"]["rows"] if "authors" in str(row[0])]
        for row in rows:
            printed = printed_row(table, "scissors", row)
            assert printed is not None and set(printed[0]) <= set(turned)
        assert [row for row in shown["means"]["rows"] if NOT_RUN in row]


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
        id="still", category=CATEGORY, structure=Structure((), ()), joints=(), part_extents=file.extents, facing=file.facing
    )
    write_scans(still, base, file.scans(), file.provenance)
    hinged = SimpleNamespace(**vars(base) | {"id": "unseen", "structure": file.structure, "joints": file.joints})
    scans = file.scans()
    none = {field.name: getattr(scans, field.name)[:0] for field in fields(scans) if field.name != "refused"}
    write_scans(unseen, hinged, Scans(**none, refused=Counter({"too small": 4})), file.provenance)
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


def test_networks_of_which_one_is_trained_anew_are_none(judged: Workspace) -> None:
    cell = Cell(CATEGORY, "supervised", 0)
    assert cell.weights(judged)
    record = judged.record(cell.stage("npcs"))
    assert record is not None
    judged.forget(cell.stage("npcs"))
    assert cell.weights(judged) is None
    judged.write_record(cell.stage("npcs"), StageRecord({**record.inputs, "data": "others"}))
    assert cell.weights(judged) is None, "what the one says does not go with what the other says"


def test_what_is_trained_is_judged_where_there_are_scans_of_it(scanned: Scanned) -> None:
    stage = JudgeTrained(scanned.workspace, FAMILY, device="cpu")
    found = stage.run(Listener())
    assert list(found.data) == ["table-2"], "no rough scans, and no category of the other tables"
    assert (stage.plan().steps, stage.plan().seconds) == ((), 0.0)
    assert list(found.data["table-2"]) == [CATEGORY]


def test_the_report_says_that_figures_of_scans_are_outdated(judged: Workspace) -> None:
    page = judged.report / "index.html"
    Report(judged).run(Listener())
    assert "Table 2, poses" in page.read_text(encoding="utf-8")
    assert OUTDATED not in page.read_text(encoding="utf-8")
    weights, _ = Cell(CATEGORY, "supervised", 0).weights(judged) or pytest.fail("not trained")
    header = weights.with_suffix(".json")
    header.write_text(json.dumps(json.loads(header.read_text()) | {"sha256": "of others"}))
    Report(judged).run(Listener())
    assert OUTDATED in page.read_text(encoding="utf-8")
    shutil.rmtree(judged.scans)
    Report(judged).run(Listener())
    assert OUTDATED in page.read_text(encoding="utf-8"), "also where scans are gone"


def test_the_report_shows_what_each_setting_makes_of_the_same_scans(judged: Workspace) -> None:
    taken_for(judged, "semi-weakly", 0)
    by_title = {section.title: section for section in picture_sections(judged)}
    pictures = by_title[f"Scans of {CATEGORY}, by setting"].pictures
    settings = [picture.title.partition(": ")[0] for picture in pictures]
    assert settings == ["supervised", "semi-weakly"] * (len(pictures) // 2)
    frames = [picture.title.partition(": ")[2] for picture in pictures]
    assert frames[::2] == frames[1::2]
    assert len(set(frames)) == min(COMMON, count_objects(open_scan_dataset(judged, CATEGORY).files["test"]))


def test_the_report_shows_no_pictures_of_what_has_changed_since(judged: Workspace) -> None:
    assert list(picture_sections(judged))
    next(scans_of(judged, CATEGORY, "test").glob("*.safetensors")).unlink()
    assert not list(picture_sections(judged))


def test_a_category_without_test_objects_is_said_to_be_not_judged(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    shutil.rmtree(tmp_path / "workspace" / "eval", ignore_errors=True)
    shutil.rmtree(tmp_path / "workspace" / "scans" / CATEGORY / "test")
    stage, told = JudgeTrained(Workspace(tmp_path / "workspace"), FAMILY, device="cpu"), Listener()
    assert stage.plan().steps == ()
    stage.run(told)
    assert [note for note in told.notes if "not judged" in note and "expected scans of a test object" in note]


@pytest.mark.parametrize("is_scanned", [True, False])
def test_without_time_no_cell_is_run_and_all_are_told(scanned: Scanned, tmp_path: Path, is_scanned: bool) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    for folder in ("eval", *(() if is_scanned else ("scans", "own-scans", "models"))):
        shutil.rmtree(tmp_path / "workspace" / folder, ignore_errors=True)
    told = Listener()
    stage = MakeTable("2", Workspace(tmp_path / "workspace"), scanned.config, ("kinmo",), FAMILY, 1, hours=0.0, **HOW)
    found = stage.run(told)
    made = [row for row in TABLES["2"].rows if row.method == "kinmo"]
    assert sum(note.startswith("not run") for note in told.notes) == len(made) == len(TABLES["2"].rows) - 1
    text = " ".join((found.path / CATEGORY / "means.md").read_text(encoding="utf-8").split())
    for row in made:
        assert f"Not run: {row.title}: " in text
    assert "Not run: supervised: it would have taken longer than --hours." in text
    assert (found.path / CATEGORY / "parts.md").exists() is is_scanned
    assert {row[2 if is_scanned else 1] for row in found.data[CATEGORY]["means"]["rows"]} == {NOT_RUN}


def test_what_is_done_for_scans_that_are_to_be_made_anew_is_to_be_done_again(
    scanned: Scanned, judged: Workspace, tmp_path: Path
) -> None:
    config = tmp_path / "other.toml"
    config.write_text(Path(scanned.config).read_text(encoding="utf-8").replace("size = 96", "size = 80"), encoding="utf-8")
    plans = [MakeTable("4", judged, name, ("kinmo",), FAMILY, 1, **HOW).plan() for name in (scanned.config, str(config))]
    assert plans[0].steps == ()
    assert plans[1].steps == (f"{CATEGORY}, supervised, seed 0: render, train, judge",)
    training = TrainAncsh(judged, str(config), FAMILY, "supervised", **HOW).guess().seconds
    assert plans[1].seconds > training > 0.0


@pytest.mark.parametrize("threads", [0, 1])
def test_training_takes_as_long_before_there_are_scans_as_with_them(scanned: Scanned, tmp_path: Path, threads: int) -> None:
    text, config = Path(scanned.config).read_text(encoding="utf-8"), tmp_path / "threads.toml"
    others, own = text.split("[ancsh]\n")
    config.write_text(f"{others}[ancsh]\n{own.replace('threads = 1', f'threads = {threads}')}", encoding="utf-8")
    stages = [TrainAncsh(scanned.workspace, str(config), FAMILY, "supervised", 1, "cpu", workers) for workers in (1, 2)]
    alone, together = (stage.plan().seconds for stage in stages)
    assert [stage.guess().seconds for stage in stages] == [alone, together]
    assert (together < alone) is (threads == 1), "on all threads one network is trained at a time"


def test_a_table_whose_motion_networks_have_none_to_go_on_from_says_so(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace, told = Workspace(tmp_path / "workspace"), Listener()
    stage = MakeTable("3", workspace, scanned.config, ("kinmo",), FAMILY, 1, start=Workspace(tmp_path / "none"), **HOW)
    problem = re.escape(f"{tmp_path / 'none'}") + ".*--from: expected the weights to go on from"
    for begin in (stage.plan, lambda: stage.run(told)):
        with pytest.raises(InputError, match=problem):
            begin()
    assert not told.notes


def test_categories_that_the_paper_varies_have_three_seeds_unless_it_is_said(scanned: Scanned) -> None:
    stage = MakeTable("2", scanned.workspace, scanned.config, ("kinmo",), **HOW)
    counts = {name: len(stage._seeds_of(name)) for name in ("Refrigerator", "Scissors", "Door", "Table", "Dishwasher")}
    assert counts == {"Refrigerator": 3, "Scissors": 3, "Door": 1, "Table": 1, "Dishwasher": 1}
    assert replace(stage, seeds=2)._seeds_of("Scissors") == replace(stage, seeds=2)._seeds_of("Door") == (0, 1)


def test_within_some_hours_what_fits_is_run(scanned: Scanned, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    shutil.rmtree(tmp_path / "workspace" / "eval", ignore_errors=True)
    stage = MakeTable("4", Workspace(tmp_path / "workspace"), scanned.config, ("kinmo",), FAMILY, 2, **HOW)
    row = TABLES["4"].rows[0]
    trained, untrained = (stage._pending(row, CATEGORY, seed, {}).seconds for seed in (0, 1))
    assert 0.0 < trained < untrained, "the second is to be trained first"
    monkeypatch.setattr("kinmo.pipeline.scans.make_table.time.monotonic", lambda: 0.0)
    told = Listener()
    found = replace(stage, hours=(trained + untrained) / 2 / 3600).run(told)
    assert f"not run: {CATEGORY}, supervised, seed 1: {TOO_LONG}" in told.notes
    rows = {row[0]: row for row in found.data[CATEGORY]["means"]["rows"]}
    assert rows["supervised"][2] == "0"


def test_a_training_that_dies_leaves_the_other_cells_and_says_so_in_the_table(
    scanned: Scanned, judged: Workspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    stage = MakeTable("4", judged, scanned.config, ("kinmo",), FAMILY, 2, **HOW)
    problem = "the process that trained npcs died: too little memory?"

    def die(training: TrainAncsh, observer: object) -> None:
        if training.seed == 1:
            raise ChildProcessError(problem)

    monkeypatch.setattr(TrainAncsh, "run", die)
    told = Listener()
    found = stage.run(told)
    assert [note for note in told.notes if note == f"not run: {CATEGORY}, supervised, seed 1: {problem}"]
    rows = {row[0]: row for row in found.data[CATEGORY]["means"]["rows"]}
    assert rows["supervised"][2] == "0"
    assert f"Not run: supervised: seeds 1: {problem}." in " ".join(found.text.split())
