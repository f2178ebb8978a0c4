"""What the report shows of scans."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.tables import read_table
from kinmo.experiments.scan_tables.table_rows import TABLES
from kinmo.experiments.scan_tables.written_tables import WrittenTables
from kinmo.pipeline.scans.scan_networks import pictures_path, trained_by_all_methods
from kinmo.pipeline.scans.scan_pictures import HIT_DEGREES, HIT_IOU, ScanPicture, read_pictures
from kinmo.pipeline.scans.scored_scans import JudgedScans
from kinmo.pipeline.scans.training_settings import SETTINGS, by_method
from kinmo.view.report_page import Picture, Section
from kinmo.view.report_tables import shown

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
    """By category: the same scans by the networks of every setting, of the first seed; then hits and failures of one.

    There are none of judgements that hold no more.
    """
    judged = [each for each in trained_by_all_methods(workspace) if JudgedScans(*each).held()]
    judged.sort(key=lambda each: SETTINGS.index(each[1].setting))
    for category in sorted({cell.category for _, cell in judged}):
        own = [(place, cell) for place, cell in judged if cell.category == category]
        first = min(cell.seed for _, cell in own)
        pictures = {
            by_method(cell.setting, place.method): read_pictures(pictures_path(place, cell))
            for place, cell in own
            if cell.seed == first
        }
        common = _side_by_side(pictures)
        if common and len(pictures) > 1:
            yield Section(f"Scans of {category}, by setting", LEGEND, pictures=common)
        name = "semi-weakly" if "semi-weakly" in pictures else next(iter(pictures))
        for title, wanted in (("hits", True), ("failures", False)):
            chosen = (p for p in pictures[name] if p.is_hit is wanted and not p.is_common)
            some = [Picture(p.svg, f"{p.id}, frame {p.frame}", [p.text]) for p in chosen]
            if some:
                yield Section(f"Scans of {category}, {title} ({name})", LEGEND, pictures=some)


def _side_by_side(pictures: Mapping[str, Sequence[ScanPicture]]) -> list[Picture]:
    """A scan after the other, each by every setting, in their order."""
    common = [(p, name) for name, some in pictures.items() for p in some if p.is_common]
    common.sort(key=lambda each: (each[0].id, each[0].frame))
    return [Picture(p.svg, f"{name}: {p.id}, frame {p.frame}", [p.text]) for p, name in common]
