"""Scans in the report."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace

import pytest
from scanned_workspace import CATEGORY, pass_networks_off
from trained_workspace import Recorder

from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.scans.scan_dataset import open_scan_dataset, scans_of
from kinmo.pipeline.scans.scan_networks import Cell, pictures_path
from kinmo.pipeline.scans.scan_pictures import COMMON, read_pictures
from kinmo.scans.files.scan_file import count_objects
from kinmo.view import scan_sections as report
from kinmo.view.report import Report
from kinmo.view.scan_sections import OUTDATED, picture_sections


def test_the_report_says_that_figures_of_scans_are_outdated(evaluated: Workspace) -> None:
    page = evaluated.report / "index.html"
    Report(evaluated).run(Recorder())
    assert "Table 2, poses" in page.read_text(encoding="utf-8")
    assert OUTDATED not in page.read_text(encoding="utf-8")
    weights, _ = Cell(CATEGORY, "supervised", 0).weights(evaluated) or pytest.fail("not trained")
    header = weights.with_suffix(".json")
    header.write_text(json.dumps(json.loads(header.read_text()) | {"sha256": "of others"}))
    Report(evaluated).run(Recorder())
    assert OUTDATED in page.read_text(encoding="utf-8")
    shutil.rmtree(evaluated.scans)
    Report(evaluated).run(Recorder())
    assert OUTDATED in page.read_text(encoding="utf-8"), "also where scans are gone"


def test_the_report_shows_what_each_setting_makes_of_the_same_scans(evaluated: Workspace) -> None:
    pass_networks_off(evaluated, "semi-weakly", 0)
    by_title = {section.title: section for section in picture_sections(evaluated)}
    pictures = by_title[f"Scans of {CATEGORY}, by setting"].pictures
    settings = [picture.title.partition(": ")[0] for picture in pictures]
    assert settings == ["supervised", "semi-weakly"] * (len(pictures) // 2)
    frames = [picture.title.partition(": ")[2] for picture in pictures]
    assert frames[::2] == frames[1::2]
    assert len(set(frames)) == min(COMMON, count_objects(open_scan_dataset(evaluated, CATEGORY).files["test"]))


def test_the_report_shows_hits_and_failures_apart(evaluated: Workspace, monkeypatch: pytest.MonkeyPatch) -> None:
    known = read_pictures(pictures_path(evaluated, Cell(CATEGORY, "supervised", 0)))
    own = [replace(picture, is_hit=row % 2 == 0) for row, picture in enumerate(p for p in known if not p.is_common)]
    assert len(own) > 1
    monkeypatch.setattr(report, "read_pictures", lambda path: own)
    sections = {section.title: section for section in picture_sections(evaluated)}
    for title, wanted in (("hits", own[::2]), ("failures", own[1::2])):
        shown = sections[f"Scans of {CATEGORY}, {title} (supervised)"].pictures
        assert [picture.title for picture in shown] == [f"{each.id}, frame {each.frame}" for each in wanted]
        assert all("parts turned by" in picture.lines[0] for picture in shown)
    Report(evaluated).run(Recorder())
    page = (evaluated.report / "index.html").read_text(encoding="utf-8")
    assert f"Scans of {CATEGORY}, hits (supervised)" in page and f"Scans of {CATEGORY}, failures (supervised)" in page


def test_the_report_shows_no_pictures_of_what_has_changed_since(evaluated: Workspace) -> None:
    assert list(picture_sections(evaluated))
    next(scans_of(evaluated, CATEGORY, "test").glob("*.safetensors")).unlink()
    assert not list(picture_sections(evaluated))
