"""Layout of the tables of scans, with printed figures and missing rows."""

from __future__ import annotations

import numpy as np
import pytest

from kinmo.core.errors import InputError
from kinmo.core.joint import JointKind
from kinmo.evaluation.paper_tables import paper_tables
from kinmo.evaluation.scan_metrics import FrameScore
from kinmo.evaluation.scan_records import ACCURACIES, ObjectScans, read_scores, summary, write_scores
from kinmo.evaluation.tables import Caption, as_text
from kinmo.experiments.scan_tables.scan_table_layout import (
    NOT_RUN,
    OUTDATED,
    ScanRow,
    by_part,
    over_categories,
    over_parts,
    printed_structure,
)
from kinmo.scans.object_structure import Structure

STRUCTURE = Structure((JointKind.REVOLUTE, JointKind.PRISMATIC), (0, 0))
CAPTION = Caption("Table 2", "made up", 0, 0, "test", (0,))


def frame(rotation=(0.1, 0.2, 0.3), iou=(0.9, 0.8, 0.7), state=(0.2, 0.05), axis=(0.01, 0.02), line=(0.03, np.nan)):
    three = np.array([0.01, 0.02, 0.03])
    joints = np.array(state), np.full(2, np.nan), np.array(axis), np.array(line)
    return FrameScore(np.array(rotation), three, np.array(iou), *joints)


def objects(*frames):
    return tuple(ObjectScans(f"object-{i}", tuple(own)) for i, own in enumerate(frames))


def test_scores_come_back_from_their_file(tmp_path):
    path = tmp_path / "scores.jsonl"
    write_scores(path, [("b", frame()), ("a", frame(rotation=(np.nan, 0.2, 0.3))), ("b", frame(iou=(1.0, 1.0, 1.0)))])
    found = read_scores([path])
    assert [(scored.id, len(scored.frames)) for scored in found] == [("a", 1), ("b", 2)]
    np.testing.assert_array_equal(found[0].frames[0].rotation, [np.nan, 0.2, 0.3])
    assert len(read_scores([path, path])[1].frames) == 4, "seeds add frames to the same object"
    path.write_text('{"id": "a"}\n')
    with pytest.raises(InputError, match=r"scores\.jsonl: expected scores of scans"):
        read_scores([path])


def test_units_are_never_mixed_and_missing_parts_are_no_zeros():
    lost = frame(rotation=(np.nan,) * 3, iou=(np.nan,) * 3, state=(np.nan,) * 2, axis=(np.nan,) * 2, line=(np.nan,) * 2)
    values = summary(objects([frame(), lost]), STRUCTURE)
    assert values["rotation (deg)"].value == pytest.approx(np.degrees(0.2))
    assert values["3D IoU (%)"].value == pytest.approx(80.0)
    assert values["state (deg)"].value == pytest.approx(np.degrees(0.2)), "the hinge alone"
    assert values["state (diag.)"].value == pytest.approx(0.05), "the slider alone"
    assert values["line"].value == pytest.approx(0.03)
    table = by_part([ScanRow("ours", objects([frame(), lost]))], STRUCTURE, CAPTION)
    failed = [column.title for column in table.columns].index("failed (%)")
    assert [row[failed] for row in table.rows] == [50.0] * 3


def test_accuracies_are_shown_on_request():
    rotation = np.radians([4.9, 5.1, np.nan])
    scored = FrameScore(rotation, np.array([0.06, 0.04, np.nan]), *(np.zeros(n) for n in (3, 2, 2, 2, 2)))
    right = FrameScore(np.zeros(3), np.full(3, 0.04), *(np.zeros(n) for n in (3, 2, 2, 2, 2)))
    printed = [[12.0, 18.0, 21.0], [0.1, 0.7, 0.6], [73.0, 3.0, 5.0], [16.0, 0.3], [1.75, 1.78], [0.035]]
    table = by_part([ScanRow("ours", objects([scored, right]), printed)], STRUCTURE, CAPTION, ACCURACIES)
    titles = [column.title for column in table.columns]
    shares = [[row[titles.index(title)] for row in table.rows] for title in ("within 5 deg (%)", "within 5 deg, .05 (%)")]
    assert shares == [[100.0, 50.0, 100.0, None, None, None], [50.0, 50.0, 100.0, None, None, None]]


def test_a_row_without_scores_says_so_and_printed_figures_follow_their_row():
    printed = [[12.0, 18.0, 21.0], [0.1, 0.7, 0.6], [73.0, 3.0, 5.0], [16.0, 0.3], [1.75, 1.78], [0.035]]
    rows = [ScanRow("supervised", objects([frame()]), printed), ScanRow("self-training", ())]
    table = by_part(rows, STRUCTURE, CAPTION)
    text = as_text(table)
    assert "supervised, authors' data" in text
    assert NOT_RUN in text
    titles = [column.title for column in table.columns]
    authors = [dict(zip(titles, row, strict=True)) for row in table.rows if "authors" in str(row[0])]
    assert [row["rotation (deg)"] for row in authors] == [12.0, 18.0, 21.0]
    assert [row["state (deg)"] for row in authors] == [None, 16.0, None]
    assert [row["state (diag.)"] for row in authors] == [None, None, 0.3]
    means = over_parts(rows, STRUCTURE, CAPTION)
    (row,) = (dict(zip([c.title for c in means.columns], row, strict=True)) for row in means.rows if "authors" in str(row[0]))
    assert (row["rotation (deg)"], row["axis (deg)"]) == (pytest.approx(17.0), pytest.approx(1.765))
    assert (row["state (deg)"], row["state (diag.)"]) == (16.0, 0.3)
    assert NOT_RUN in as_text(over_parts(rows, STRUCTURE, CAPTION))


def test_printed_figures_keep_their_units_whatever_the_structure():
    drawers = Structure((JointKind.PRISMATIC,), (0,))
    two = np.array([0.4, 0.4])
    drawer = FrameScore(two, two, two, np.array([0.2]), np.array([np.nan]), np.array([0.1]), np.array([np.nan]))
    printed = paper_tables()["table2"]["categories"]["refrigerator"]["ANCSH"]
    row = ScanRow("supervised", (ObjectScans("drawer", (drawer,)),), printed)
    found = by_part([row], drawers, CAPTION)
    titles = [column.title for column in found.columns]
    authors = [dict(zip(titles, line, strict=True)) for line in found.rows if "authors" in str(line[0])]
    assert [line["rotation (deg)"] for line in authors] == printed[0], "three parts, although the test objects have two"
    assert [line["state (diag.)"] for line in authors] == [None] * 3, "the paper's doors have degrees, not lengths"
    means = over_parts([row], drawers, CAPTION)
    titles = [column.title for column in means.columns]
    (line,) = (dict(zip(titles, line, strict=True)) for line in means.rows if "authors" in str(line[0]))
    assert line["rotation (deg)"] == pytest.approx(np.mean(printed[0]))
    assert line["state (diag.)"] is None


def test_categories_count_equally_and_only_in_their_own_measures():
    slides = Structure((JointKind.PRISMATIC,), (0,))
    doors = objects([frame(rotation=(0.1, 0.2, 0.3))] * 3)
    two = np.array([0.4, 0.4])
    drawer = FrameScore(two, two, two, np.array([0.2]), np.array([np.nan]), np.array([0.1]), np.array([np.nan]))
    drawers = [ObjectScans("drawer", (drawer,))]
    run = {"one": (doors, drawers), "two": (doors, ()), "three": ((), ()), "four": ((), ())}
    rows = {
        name: {"Door": ScanRow(name, tuple(those)), "Table": ScanRow(name, tuple(these))}
        for name, (those, these) in run.items()
    }
    rows["four"]["Table"] = ScanRow("four", (), absent=OUTDATED)
    table = over_categories(rows, {"Door": STRUCTURE, "Table": slides}, CAPTION)
    found = [dict(zip([column.title for column in table.columns], row, strict=True)) for row in table.rows]
    assert [row["categories"] for row in found] == [2, 1, NOT_RUN, OUTDATED]
    assert found[0]["rotation (deg)"] == pytest.approx(np.degrees(0.3))
    assert found[1]["rotation (deg)"] == pytest.approx(np.degrees(0.2))
    alone = summary(doors, STRUCTURE)["state (deg)"]
    assert found[0]["state (deg)"] == pytest.approx(alone.value), "a drawer has no angle"
    most = [doors, drawers]
    assert table.caption.shapes == sum(map(len, most))
    assert table.caption.scans == sum(len(scored.frames) for own in most for scored in own)


def test_a_comparison_follows_the_rows_with_its_interval():
    before, after = (
        ScanRow(name, objects([frame(rotation=(turn,) * 3)]), seeds=(0, 2)) for name, turn in (("a", 0.3), ("b", 0.1))
    )
    table = over_parts([before, after], STRUCTURE, CAPTION, [(before, after)])
    row = dict(zip([column.title for column in table.columns], table.rows[-1], strict=True))
    assert (row["trained on"], row["seeds"]) == ("b against a", "0, 2")
    assert row["rotation (deg)"] == pytest.approx(np.degrees(-0.2))
    assert table.rows[-1][4] == "-11.46 to -11.46"


def test_means_of_printed_figures_never_mix_lengths_and_degrees():
    """The mean state that the paper prints in Table 2 has the .30 of the category Table among the degrees."""
    tables = paper_tables()["table2"]
    for name, state in (("ANCSH", 23.91), ("ANCSH (Semi)", 27.68), ("ANCSH (Semi-weakly)", 16.60)):
        by_category = {key: ScanRow("ours", (), figures[name]) for key, figures in tables["categories"].items()}
        table = over_categories({"ours": by_category}, {}, CAPTION)
        ours, authors = (dict(zip([column.title for column in table.columns], row, strict=True)) for row in table.rows)
        assert ours["categories"] == NOT_RUN
        assert authors["categories"] == 5
        rotation, _, iou, _, axis, _ = tables["printed_mean"][name]
        assert authors["rotation (deg)"] == pytest.approx(rotation, abs=0.006)
        assert authors["3D IoU (%)"] == pytest.approx(iou, abs=0.06)
        assert authors["axis (deg)"] == pytest.approx(axis, abs=0.006)
        assert authors["state (deg)"] == pytest.approx(state, abs=0.006)
    (kinds,) = (printed_structure(tables["categories"]["table"]["ANCSH"]).kinds,)
    assert kinds == (JointKind.PRISMATIC,)
