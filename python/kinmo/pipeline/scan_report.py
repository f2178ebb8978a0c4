"""What the report shows of scans."""

from __future__ import annotations

from collections.abc import Iterator

from kinmo.evaluation.tables import read_table
from kinmo.pipeline.ancsh_files import Cell, pictures_path, trained_cells
from kinmo.pipeline.report_tables import shown
from kinmo.pipeline.scan_pictures import HIT_DEGREES, HIT_IOU, read_pictures
from kinmo.pipeline.scan_table_rows import TABLES
from kinmo.pipeline.written_scan_tables import WrittenTables
from kinmo.report.page import Picture, Section
from kinmo.workspace import Workspace

LEGEND = (
    "Left what was found, right the truth, as the camera sees them: points in the colours of their parts, amodal boxes, and "
    f"axes. A frame is a hit if every part is turned right within {HIT_DEGREES:g}° and every box overlaps the true one by "
    f"{HIT_IOU:.0%}."
)

OUTDATED = (
    "Since these tables were written, networks or scans have changed, or more was judged: the same kinmo eval, or kinmo table, "
    "gives the figures of what is there now."
)


def table_sections(workspace: Workspace) -> Iterator[Section]:
    """Tables of scans, a section a category."""
    for name, table in TABLES.items():
        written = WrittenTables(workspace, name)
        folders = sorted(path for path in written.folder.glob("*") if path.is_dir())
        for folder in folders:
            found = {path.stem: read_table(path) for path in sorted(folder.glob("*.json"))}
            tables = [shown(found[key]) for key in ("means", "parts") if key in found]
            more = [shown(other) for key, other in found.items() if key not in ("means", "parts")]
            note = "" if written.is_current(folder.name) else OUTDATED
            yield Section(f"{table.title}: {folder.name}", note, tables=tables, more=more)


def picture_sections(workspace: Workspace) -> Iterator[Section]:
    """Hits and failures of the networks of every category: of the first seed, and of one setting."""
    chosen: dict[str, Cell] = {}
    for cell in trained_cells(workspace):
        if pictures_path(workspace, cell, on_rough=False).exists():
            best = chosen.get(cell.category)
            if best is None or (cell.setting != "semi-weakly", cell.seed) < (best.setting != "semi-weakly", best.seed):
                chosen[cell.category] = cell
    for category, cell in sorted(chosen.items()):
        pictures = read_pictures(pictures_path(workspace, cell, on_rough=False))
        for title, wanted in (("hits", True), ("failures", False)):
            some = [Picture(p.svg, f"{p.id}, frame {p.frame}", [p.text]) for p in pictures if p.is_hit is wanted]
            if some:
                yield Section(f"Scans of {category}, {title} ({cell.setting})", LEGEND, pictures=some)
