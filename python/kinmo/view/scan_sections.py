"""Sections of the report about scans: tables and pictures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.tables import read_table
from kinmo.experiments.scan_tables.table_rows import TABLES, with_method
from kinmo.experiments.scan_tables.written_tables import WrittenTables
from kinmo.methods import DEFAULT_METHOD
from kinmo.pipeline.scans.scan_networks import trained_runs
from kinmo.pipeline.scans.scan_pictures import HIT_DEGREES, HIT_IOU, ScanPicture, read_pictures
from kinmo.pipeline.scans.scan_scores import ScanScores
from kinmo.pipeline.scans.training_settings import SETTINGS
from kinmo.view.report_page import Picture, Section, Table

LEGEND = (
    "Left the prediction, right the truth, as the camera sees them: points in the colours of their parts, amodal boxes, and "
    f"axes. A frame is a hit if every part is turned right within {HIT_DEGREES:g}° and every box overlaps the true one by "
    f"{HIT_IOU:.0%}."
)
OUTDATED = "Networks or scans have changed since, or more was evaluated: run the same kinmo eval or kinmo table again."


def table_sections(workspace: Workspace) -> Iterator[Section]:
    """One section for each table and category: the summary, and everything else folded."""
    for name, table in TABLES.items():
        written = WrittenTables(workspace, name)
        for folder in sorted(path for path in written.folder.glob("*") if path.is_dir()):
            found = {path.stem: read_table(path) for path in sorted(folder.glob("*.json"))}
            first = "summary" if "summary" in found else "means"
            tables = [Table.of(found[first])] if first in found else []
            more = [Table.of(other) for key, other in found.items() if key != first]
            note = "" if written.is_current(folder.name) else OUTDATED
            yield Section(f"{table.title}: {folder.name}", note, tables=tables, more=more)


def picture_sections(workspace: Workspace) -> Iterator[Section]:
    """Pictures of each category: the same scans by the networks of every setting, then hits and failures of one setting.

    Networks with outdated scores are skipped.
    """
    scored = [scores for run in trained_runs(workspace) if (scores := ScanScores(workspace, run)).current_inputs()]
    scored.sort(key=lambda scores: SETTINGS.index(scores.run.setting))
    for category in sorted({scores.run.category for scores in scored}):
        own = [scores for scores in scored if scores.run.category == category]
        first = min(scores.run.seed for scores in own)
        pictures = {
            with_method(scores.run.setting, scores.run.method if scores.run.setting == "semi-weakly" else DEFAULT_METHOD): (
                read_pictures(scores.pictures)
            )
            for scores in own
            if scores.run.seed == first
        }
        common = _side_by_side(pictures)
        if common and len(pictures) > 1:
            yield Section(f"Scans of {category}, by setting", LEGEND, pictures=common)
        name = "semi-weakly" if "semi-weakly" in pictures else next(iter(pictures))
        for title, wanted in (("hits", True), ("failures", False)):
            chosen = (p for p in pictures[name] if p.is_hit is wanted and not p.is_common)
            drawn = [Picture(p.svg, f"{p.id}, frame {p.frame}", [p.text]) for p in chosen]
            if drawn:
                yield Section(f"Scans of {category}, {title} ({name})", LEGEND, pictures=drawn)


def _side_by_side(pictures: Mapping[str, Sequence[ScanPicture]]) -> list[Picture]:
    """Pictures of the common frames, one scan after the other, by every setting."""
    common = [(p, name) for name, own in pictures.items() for p in own if p.is_common]
    common.sort(key=lambda pair: (pair[0].id, pair[0].frame))
    return [Picture(p.svg, f"{name}: {p.id}, frame {p.frame}", [p.text]) for p, name in common]
