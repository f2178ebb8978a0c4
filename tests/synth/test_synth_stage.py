"""The stage `Synth`: its plan and its result."""

from __future__ import annotations

from pathlib import Path

from kinmo.dataset.stage import SilentObserver
from kinmo.synth.synth_stage import Synth


def test_a_plan_has_the_shapes_that_are_missing(tmp_path: Path) -> None:
    stage = Synth(tmp_path, 2, ("laptop",), ("partnet",))
    assert "write 2 procedural shapes" in stage.plan().steps[0]
    outcome = stage.run(SilentObserver())
    assert (outcome.data["shapes"], outcome.data["written"]) == (2, 2)
    assert stage.plan().steps == ()
    assert Synth(tmp_path, 3, ("laptop",), ("partnet",)).run(SilentObserver()).data["written"] == 1


def test_a_family_that_is_named_twice_is_written_once(tmp_path: Path) -> None:
    stage = Synth(tmp_path, 2, ("laptop", "laptop"), ("partnet", "partnet"), workers=2)
    assert stage.run(SilentObserver()).data == {"folder": str(tmp_path), "shapes": 2, "written": 2}
