"""Notes about predictions: guesses, sizes, folders of meshes, doubtful axes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from cabinet_results import cabinet_prediction

from kinmo.io.discover import ShapeSource
from kinmo.pipeline.prediction_summary import notes_about, summary_of

GUESS = {"up": "up +y (OBJ)"}


def document(**changes: Any) -> dict[str, Any]:
    """Facts about a good prediction with some changes."""
    plain = {"id": "desk", "folder": "out/desk", "layout": "obj", "parts": 4, "joints": 2, "mean_score": 0.9, "diagonal": 1.0}
    return {**plain, "metres_per_unit": 1.0, "guessed": {}, "repairs": [], "notes": [], "corrected": False, **changes}


def notes(*documents: dict[str, Any]) -> list[str]:
    return list(notes_about(documents, ()))


def test_the_summary_names_the_urdf_only_if_it_was_written(tmp_path: Path) -> None:
    prediction, folder = cabinet_prediction(tmp_path), tmp_path / "out"
    found = ShapeSource(prediction.shape.source, prediction.shape.layout, prediction.shape.id)
    prediction.export(folder, ["glb", "joints_json"], collision="none")
    assert "urdf" not in summary_of(found, folder)[0]
    written = prediction.export(folder, ["urdf", "joints_json"], collision="none", overwrite=True)
    assert summary_of(found, folder)[0]["urdf"] == str(written["urdf"])


def test_a_good_prediction_has_no_notes() -> None:
    assert notes(document()) == []


@pytest.mark.parametrize(
    ("changes", "note"),
    [
        ({"layout": "mesh_folder"}, "desk: its mesh files are the parts of one shape: name files singly if each is a shape"),
        ({"parts": 1}, "desk: has one part, so nothing can move: cut it into one node per moving part"),
        ({"diagonal": 900.0}, "desk: 900 m across: set --metres-per-unit if the file is not in metres"),
        ({"corrected": True}, "desk: corrected by out/desk/overrides.toml"),
        ({"repairs": ["a", "b"]}, "repaired: desk: a; b"),
        ({"notes": ["lid_joint stops"]}, "export of desk: lid_joint stops"),
    ],
)
def test_facts_to_know_are_noted(changes: dict[str, Any], note: str) -> None:
    assert notes(document(**changes)) == [note]


@pytest.mark.parametrize(
    ("changes", "is_doubtful"), [({}, True), ({"layout": "glb"}, False), ({"mean_score": 0.9}, False), ({"joints": 0}, False)]
)
def test_low_scores_make_a_guessed_up_direction_doubtful(changes: dict[str, Any], is_doubtful: bool) -> None:
    found = notes(document(**{"guessed": GUESS, "mean_score": 0.5, **changes}))
    assert ("desk: low scores: is another axis up? (--up z, --up y)" in found) == is_doubtful


def test_equal_guesses_share_a_line() -> None:
    others = [
        document(folder="out/bed", guessed=GUESS),
        document(folder="out/desk", guessed=GUESS),
        document(folder="out/lamp", guessed={"up": "up +z"}),
    ]
    assert notes(*others) == [
        "guessed for 2 shapes, such as bed: up +y (OBJ) (if wrong: --up)",
        "guessed for lamp: up +z (if wrong: --up)",
    ]
