"""Tables of figures for the report."""

from __future__ import annotations

from kinmo.evaluation.tables import DASH, INTERVAL
from kinmo.evaluation.tables import Table as FigureTable
from kinmo.view.report_page import Table


def page_table(table: FigureTable) -> Table:
    """A table of figures as text, with its facts below and intervals below their figures."""
    titles, *rows = [list(cells) for cells in table.cells()]
    for place in reversed(range(len(titles))):
        if table.columns[place] == INTERVAL:
            for cells in (titles, *rows):
                interval = cells.pop(place)
                cells[place - 1] += "" if interval == DASH else f"\n{interval}"
    return Table(table.caption.title, titles, rows, table.caption.facts)
