"""Figures over joints, objects and categories: what counts, what does not, and how sure one may be."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinmo.core.joint import CoarseType, MotionType
from kinmo.evaluation.aggregate import macro, micro, ratios
from kinmo.evaluation.joint_records import FalseAlarm, JointRecord, ShapeScore
from kinmo.evaluation.paper_tables import METHODS, mean, paper_tables, table1_figures, table1_means
from kinmo.evaluation.summary import FIGURES, summarise, without_controls
from kinmo.evaluation.tables import WRITERS, Caption, Column, Table, as_latex, as_markdown, as_text, write_table
from kinmo.experiments.table1.table1_tables import Scores, by_category, overview, overviews

CAPTION = Caption("Table 1", "procedural", 0, 0, "test", (0, 1))


def record(shape_id="a", category="Door", body=0, *, axis=0.0, line=0.0, name="door", type=MotionType.R_V_S, **change):
    figures = {} if axis is None else {"axis_error": math.radians(axis), "line_distance": line, "line_at_part": line}
    answer = None if axis is None else type
    return JointRecord(shape_id, category, body, name, type, 2.0, **{"predicted_type": answer, **figures, **change})


def shape(shape_id, category, *records, alarms=(), is_fine=True):
    return ShapeScore(shape_id, category, tuple(records), tuple(FalseAlarm(name, 0.5) for name in alarms), is_fine)


def doors(count, category="Door", **change):
    return [shape(f"{category}{i}", category, record(f"{category}{i}", category, **change)) for i in range(count)]


def test_a_missed_joint_fails_every_share_and_enters_no_mean():
    summary = summarise([shape("a", "Door", record(axis=2.0), record(body=1, axis=None))])
    assert summary.micro["missed"].value == 0.5
    assert summary.micro["ok"].value == 0.5
    assert summary.micro["axis_ok"].value == 0.5
    assert summary.micro["recall"].value == 0.5
    assert summary.micro["axis"].value == pytest.approx(2.0)
    assert summary.medians["axis"] == pytest.approx(2.0)


def test_macro_means_count_large_categories_only_and_every_one_once():
    scores = doors(8, "Door", axis=1.0) + doors(16, "Safe", axis=4.0) + doors(3, "Oven", axis=31.0) + doors(2, "Pen", axis=90.0)
    summary = summarise(scores)
    assert summary.macro[8]["axis"].value == pytest.approx(2.5)
    assert summary.macro[8]["axis"].count == 2
    assert summary.macro[3]["axis"].value == pytest.approx(12.0)
    assert summary.micro["axis"].value == pytest.approx((8 + 64 + 93 + 180) / 29)


def test_a_category_without_a_value_does_not_count_as_zero():
    slider = MotionType.P_H
    scores = doors(8, "Door", line=0.2) + doors(8, "Table", type=slider, line=None, line_distance=None, line_at_part=None)
    line = summarise(scores).macro[8]["line"]
    assert line.value == pytest.approx(0.2)
    assert line.count == 1


def test_seeds_of_one_shape_are_one_object():
    runs = [shape("a", "Door", record("a", axis=axis)) for axis in (0.0, 3.0, 30.0)]
    summary = summarise(runs)
    assert (summary.objects, summary.joints, summary.runs) == (1, 1, 3)
    assert summary.micro["axis"].value == pytest.approx(11.0)
    assert summary.micro["axis"].low == summary.micro["axis"].high == pytest.approx(11.0)


def test_false_alarms_lower_precision_and_not_recall():
    micro_figures = summarise([shape("a", "Door", record(), record(body=1, axis=None), alarms=("shelf", "knob"))]).micro
    assert micro_figures["precision"].value == pytest.approx(1 / 3)
    assert micro_figures["recall"].value == pytest.approx(1 / 2)
    assert micro_figures["f1"].value == pytest.approx(2 / 5)


def test_a_method_of_five_types_has_no_accuracy_among_ten():
    coarse = shape("a", "Door", record(predicted_type=CoarseType.R), is_fine=False)
    summary = summarise([coarse])
    assert summary.micro["fine_type"] is None
    assert summary.micro["coarse_type"].value == 1.0


def test_shapes_of_controls_only_leave_with_them():
    scores = [shape("a", "Toaster", record(name="Knob_1")), shape("b", "Door", record(), record(body=1, name="push button"))]
    kept = without_controls(scores)
    assert [(score.shape_id, len(score.records)) for score in kept] == [("b", 1)]


def test_without_controls_false_alarms_of_such_names_do_not_count_either():
    scores = [
        shape("a", "Door", record(), record(body=1, name="knob"), alarms=("Push_Button", "light switch", "shelf")),
        shape("b", "Toaster", record(name="knob"), alarms=("knob", "shelf")),
    ]
    kept = without_controls(scores)
    assert [(score.shape_id, [alarm.name for alarm in score.false_alarms]) for score in kept] == [("a", ["shelf"])]
    assert summarise(kept).micro["precision"].value == pytest.approx(1 / 2)
    assert summarise(kept).micro["f1"].value == pytest.approx(2 / 3)
    assert summarise(scores).micro["precision"].value == pytest.approx(3 / 8)


def test_the_papers_distance_is_in_the_lengths_of_the_file():
    summary = summarise([shape("a", "Door", record(line=0.1))])
    assert summary.micro["raw_line"].value == pytest.approx(0.2)


def test_an_interval_covers_the_truth_about_as_often_as_it_says():
    rng = np.random.default_rng(1)
    hits = 0
    for _ in range(100):
        successes = rng.binomial(4, 0.7, size=40)
        sums = np.stack([successes, np.full(40, 4)], axis=1)[:, None, :].astype(float)
        found = micro(sums, draws=300)[0]
        hits += found.low <= 0.7 <= found.high
    assert 85 <= hits <= 100


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5), st.sampled_from("abc")), min_size=1, max_size=20))
def test_intervals_hold_their_value_and_do_not_depend_on_the_run(rows):
    sums = np.array([[[min(a, b), b]] for a, b, _ in rows], float)
    categories = [name for *_, name in rows]
    for estimate in (*micro(sums, draws=50), *macro(sums, categories, draws=50)):
        if estimate is not None:
            assert 0 <= estimate.low <= estimate.high <= 1
    assert macro(sums, categories, draws=50) == macro(sums, categories, draws=50)


def test_nothing_counted_is_no_value():
    assert np.isnan(ratios(np.array([[0.0, 0.0]])))[0]
    assert micro(np.zeros((0, 2, 2))) == [None, None]


def test_a_summary_is_plain_json():
    document = json.loads(json.dumps(summarise(doors(3)).to_json(), allow_nan=False))
    assert set(document["micro"]) == {figure.key for figure in FIGURES}


def test_the_papers_means_without_its_dashes_counted_as_zero():
    by_method = dict(zip(METHODS, table1_means("distance"), strict=True))
    order = ("OBB_fine", "GNN_fine", "OBB_coarse", "GNN_coarse")
    assert [round(by_method[name], 4) for name in order] == [0.1319, 0.2408, 0.1275, 0.2586]


def test_the_papers_printed_means_count_dashes_as_zeros_in_distances_only():
    printed = paper_tables()["table1"]["printed_mean"]
    distances = table1_figures("distance")
    for index in range(4):
        known = [row[index] for row in distances.values()]
        assert sum(value or 0.0 for value in known) / len(known) == pytest.approx(printed["distance"][index], abs=6e-4)
        assert table1_means("angle")[index] == pytest.approx(printed["angle"][index], abs=6e-3)
    assert sum(None in row for row in distances.values()) == 3


def test_the_papers_scan_tables_recompute_to_their_means_except_where_it_mixes_units():
    tables = paper_tables()["table2"]
    for method, printed in tables["printed_mean"].items():
        rows = [methods[method] for methods in tables["categories"].values()]
        for column, expected in enumerate(printed):
            values = [mean(row[column]) for row in rows if row[column]]
            tolerance = 0.03 if column in (0, 2, 3, 4) else 0.006
            assert sum(values) / len(values) == pytest.approx(expected, abs=tolerance)


def test_table_1_shows_the_papers_figures_and_marks_them():
    table = by_category({"OBB_fine": Scores(doors(8, "door_set", axis=1.0))}, "axis", CAPTION)
    titles = [column.title for column in table.columns]
    assert titles[-4:] == [f"{name} (authors' data)" for name in METHODS]
    rows = {row[0]: row for row in table.rows}
    assert rows["Door"][1:4] == (8, 8, pytest.approx(1.0))
    assert rows["Door"][-1] == 8.6
    assert rows["Pen"][1:4] == (0, 0, None)
    assert rows["mean of 1 categories with >= 8 objects"][3] == pytest.approx(1.0)
    assert (table.caption.shapes, table.caption.joints) == (8, 8)


def test_no_table_of_ours_averages_the_papers_dashes():
    table = by_category({"OBB_fine": Scores(doors(8))}, "raw_line", CAPTION)
    rows = {row[0]: row for row in table.rows}
    assert rows["Window"][-4:] == (None,) * 4
    assert rows["mean of the paper's categories"][-1] == pytest.approx(0.1319, abs=5e-5)


def test_a_table_of_one_category_has_no_rows_of_others():
    table = by_category({"OBB_fine": Scores(doors(8))}, "axis", CAPTION, whole=False)
    own = by_category({"OBB_fine": Scores(doors(8))}, "axis", CAPTION)
    assert [row[0] for row in table.rows] == ["Door", "mean of joints", "median of joints"]
    assert set(table.rows) <= set(own.rows)


def test_table_1_comes_with_and_without_controls():
    scores = {"kinmo": [*doors(8), *(shape(f"t{i}", "Toaster", record(f"t{i}", "Toaster", name="knob")) for i in range(8))]}
    tables = overviews({name: Scores(shapes) for name, shapes in scores.items()}, CAPTION)
    assert tables["overview_micro"].rows[0][1:3] == (16, 16)
    assert tables["overview_micro_without_controls"].rows[0][1:3] == (8, 8)
    assert "Without buttons" in str(tables["overview_micro_without_controls"].caption)


def test_an_overview_prints_what_it_is_of():
    text = as_text(overview({"rule": Scores(doors(3)), "kinmo": Scores(doors(3, axis=9.0))}, CAPTION))
    assert "procedural; 3 shapes, 3 joints; test; seeds 0, 1." in text
    assert text.index("rule") < text.index("kinmo")


TABLE = Table(CAPTION, (Column("a_b & <c>"), Column("x|y", 2)), (("50 % \\ ~^{}$#", 1.005), ("", None)))


def test_every_format_holds_every_cell(tmp_path):
    paths = write_table(TABLE, tmp_path / "tables", "one")
    assert sorted(path.suffix[1:] for path in paths) == sorted(WRITERS)
    assert len(list((tmp_path / "tables").iterdir())) == len(WRITERS)
    document = json.loads((tmp_path / "tables" / "one.json").read_text())
    assert document["rows"] == [["50 % \\ ~^{}$#", 1.005], ["", None]]
    assert "one.csv" in {path.name for path in paths}
    assert (tmp_path / "tables" / "one.csv").read_text().splitlines()[2] == ","


def test_latex_prints_special_characters_as_they_are():
    text = as_latex(TABLE)
    assert r"a\_b \& \textless{}c\textgreater{} & x|y \\" in text
    assert r"50 \% \textbackslash{} \textasciitilde{}\textasciicircum{}\{\}\$\# & " in text
    assert text.count(r"\\") == 3


def test_markdown_cells_do_not_break_the_table():
    rows = as_markdown(TABLE).splitlines()[2:]
    assert all(row.replace("\\|", "").count("|") == 3 for row in rows)


def test_a_row_of_the_wrong_length_is_refused():
    with pytest.raises(ValueError, match="rows"):
        Table(CAPTION, (Column("a"),), ((1, 2),))
