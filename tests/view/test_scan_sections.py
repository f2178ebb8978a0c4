"""Scans in the report: tables, pictures by setting, and what is hidden once it is outdated."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace

import pytest
from scanned_workspace import CATEGORY, pass_networks_off
from trained_workspace import Recorder

from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.scans.scan_dataset import open_scan_dataset, scans_folder
from kinmo.pipeline.scans.scan_networks import ScanRun
from kinmo.pipeline.scans.scan_pictures import COMMON, read_pictures
from kinmo.pipeline.scans.scan_scores import ScanScores
from kinmo.scans.files.scan_file import count_objects
from kinmo.view import scan_sections
from kinmo.view.html_report import Report
from kinmo.view.scan_sections import OUTDATED, picture_sections

RUN = ScanRun(CATEGORY, "supervised", 0)


def page(workspace: Workspace) -> str:
    return Report(workspace).run(Recorder()).path.read_text(encoding="utf-8")


def test_the_report_marks_outdated_tables_of_scans(evaluated: Workspace) -> None:
    html = page(evaluated)
    assert "Table 2" in html and OUTDATED not in html
    weights, _ = RUN.weights(evaluated) or pytest.fail("not trained")
    header = weights.with_suffix(".json")
    header.write_text(json.dumps(json.loads(header.read_text()) | {"sha256": "of others"}))
    assert OUTDATED in page(evaluated)
    shutil.rmtree(evaluated.scans)
    assert OUTDATED in page(evaluated), "also without scans"


def test_tables_of_scans_show_a_summary_and_fold_the_rest(evaluated: Workspace) -> None:
    (section,) = (section for section in scan_sections.table_sections(evaluated) if section.tables)
    assert section.title.endswith(CATEGORY)
    assert len(section.tables) == 1 and section.more


def test_the_report_shows_the_same_scans_by_every_setting(evaluated: Workspace) -> None:
    pass_networks_off(evaluated, "semi-weakly", 0)
    by_title = {section.title: section for section in picture_sections(evaluated)}
    pictures = by_title[f"Scans of {CATEGORY}, by setting"].pictures
    settings = [picture.title.partition(": ")[0] for picture in pictures]
    assert settings == ["supervised", "semi-weakly"] * (len(pictures) // 2)
    frames = [picture.title.partition(": ")[2] for picture in pictures]
    assert frames[::2] == frames[1::2]
    assert len(set(frames)) == min(COMMON, count_objects(open_scan_dataset(evaluated, CATEGORY).files["test"]))


def test_the_report_separates_hits_from_failures(evaluated: Workspace, monkeypatch: pytest.MonkeyPatch) -> None:
    known = [picture for picture in read_pictures(ScanScores(evaluated, RUN).pictures) if not picture.is_common]
    own = [replace(picture, is_hit=row % 2 == 0) for row, picture in enumerate(known)]
    assert len(own) > 1
    monkeypatch.setattr(scan_sections, "read_pictures", lambda path: own)
    sections = {section.title: section for section in picture_sections(evaluated)}
    for title, wanted in (("hits", own[::2]), ("failures", own[1::2])):
        drawn = sections[f"Scans of {CATEGORY}, {title} (supervised)"].pictures
        assert [picture.title for picture in drawn] == [f"{each.id}, frame {each.frame}" for each in wanted]
        assert [picture.lines for picture in drawn] == [[each.text] for each in wanted]
    html = page(evaluated)
    assert f"Scans of {CATEGORY}, hits (supervised)" in html and f"Scans of {CATEGORY}, failures (supervised)" in html


def test_the_report_shows_no_outdated_pictures(evaluated: Workspace) -> None:
    assert list(picture_sections(evaluated))
    next(scans_folder(evaluated, CATEGORY, "test").glob("*.safetensors")).unlink()
    assert not list(picture_sections(evaluated))
