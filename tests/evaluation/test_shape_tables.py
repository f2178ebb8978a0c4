"""Tables of Table 1: figures by category beside the paper's, and overviews of all rows."""

import math

import pytest

from kinmo.core.motion_types import MotionType
from kinmo.evaluation.joint_records import JointRecord, ShapeScore
from kinmo.evaluation.paper_tables import METHODS
from kinmo.evaluation.shape_tables import Scores, by_category, overview, overviews
from kinmo.evaluation.tables import Caption, as_text

CAPTION = Caption("Table 1", "procedural", 0, 0, "test", (0, 1))


def record(shape_id="a", category="Door", *, axis=0.0, name="door"):
    errors = {"axis_error": math.radians(axis), "line_distance": 0.0, "line_at_part": 0.0}
    return JointRecord(shape_id, category, 0, name, MotionType.R_V_S, 2.0, MotionType.R_V_S, **errors)


def shape(shape_id, category, *records):
    return ShapeScore(shape_id, category, tuple(records))


def doors(count, category="Door", **change):
    """Shapes with one joint each, all with the same errors."""
    return [shape(f"{category}{i}", category, record(f"{category}{i}", category, **change)) for i in range(count)]


def test_table_1_shows_and_marks_the_figures_of_the_paper():
    table = by_category({"OBB_fine": Scores(doors(8, "door_set", axis=1.0))}, "axis", CAPTION)
    titles = [column.title for column in table.columns]
    assert titles[-4:] == [f"{name} (authors' data)" for name in METHODS]
    rows = {row[0]: row for row in table.rows}
    assert rows["Door"][1:4] == (8, 8, pytest.approx(1.0))
    assert rows["Door"][-1] == 8.6
    assert rows["Pen"][1:4] == (0, 0, None)
    assert rows["mean of 1 categories with >= 8 objects"][3] == pytest.approx(1.0)
    assert (table.caption.shapes, table.caption.joints) == (8, 8)


def test_no_table_averages_the_dashes_of_the_paper():
    table = by_category({"OBB_fine": Scores(doors(8))}, "raw_line", CAPTION)
    rows = {row[0]: row for row in table.rows}
    assert rows["Window"][-4:] == (None,) * 4
    assert rows["mean of the paper's categories"][-1] == pytest.approx(0.1319, abs=5e-5)


def test_a_table_of_one_category_has_no_rows_of_other_categories():
    table = by_category({"OBB_fine": Scores(doors(8))}, "axis", CAPTION, whole=False)
    own = by_category({"OBB_fine": Scores(doors(8))}, "axis", CAPTION)
    assert [row[0] for row in table.rows] == ["Door", "mean of joints", "median of joints"]
    assert set(table.rows) <= set(own.rows)


def test_table_1_is_written_with_and_without_controls():
    scores = {"kinmo": [*doors(8), *(shape(f"t{i}", "Toaster", record(f"t{i}", "Toaster", name="knob")) for i in range(8))]}
    tables = overviews({name: Scores(shapes) for name, shapes in scores.items()}, CAPTION)
    assert tables["overview_micro"].rows[0][1:3] == (16, 16)
    assert tables["overview_micro_without_controls"].rows[0][1:3] == (8, 8)
    assert "Without buttons" in str(tables["overview_micro_without_controls"].caption)


def test_an_overview_prints_its_data_and_counts():
    text = as_text(overview({"rule": Scores(doors(3)), "kinmo": Scores(doors(3, axis=9.0))}, CAPTION))
    assert "procedural; 3 shapes, 3 joints; test; seeds 0, 1." in text
    assert text.index("rule") < text.index("kinmo")
