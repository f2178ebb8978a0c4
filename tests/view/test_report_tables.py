"""Tables of figures in the report."""

from __future__ import annotations

from kinmo.evaluation.tables import INTERVAL, Caption, Column, Table
from kinmo.view.report_tables import page_table


def test_intervals_stand_below_their_figures_and_facts_below_the_table() -> None:
    caption = Caption("Table 2", "sample", 3, 4, "test", (0, 1), "a note")
    columns = (Column("trained on"), Column("rotation", 1), INTERVAL, Column("axis", 1), INTERVAL)
    rows = (("some", 21.44, "16 to 27", 0.4, "0.2 to 0.7"), ("authors' data", 8.0, None, None, None))
    found = page_table(Table(caption, columns, rows))
    assert found.caption == "Table 2"
    assert found.note == "sample; 3 shapes, 4 joints; test; seeds 0, 1.\na note"
    assert found.header == ["trained on", "rotation\n95 %", "axis\n95 %"]
    assert found.rows == [["some", "21.4\n16 to 27", "0.4\n0.2 to 0.7"], ["authors' data", "8.0", "–"]]
    assert [found.is_text(column) for column in range(3)] == [True, False, False]
