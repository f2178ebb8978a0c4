"""Tables of figures as the report shows them."""

from __future__ import annotations

from kinmo.evaluation.tables import Table as MeasuredTable
from kinmo.report.page import Table


def shown(table: MeasuredTable) -> Table:
    """The table as text."""
    return Table(table.caption.title, [column.title for column in table.columns], table.cells()[1:], table.caption.facts)
