"""Tables and claims of the benchmark on real objects."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from forms import FormScore
from kinmo.config import load_config
from kinmo.core.joint import JointKind
from kinmo.core.motion_types import MotionType
from kinmo.evaluation.joint_records import JointRecord, ShapeScore
from kinmo.evaluation.urdf_scoring.urdf_scores import MISSING, ObjectScore, PartScore
from real_objects import QUICK, UNSEEN, print_claim, print_rows

RIGHT = JointRecord("1", "Safe", 1, "door", MotionType.R_V_S, 1.0, MotionType.R_V_S, axis_error=0.0, line_at_part=0.0)
MISSED = replace(RIGHT, predicted_type=None, axis_error=None, line_at_part=None)
UNFOUND = ObjectScore("1", "Safe", MISSING, "no URDF", (PartScore(1, "door", JointKind.REVOLUTE),))


def test_lines_of_both_kinds_are_printed_and_claimed(capsys):
    given = [ShapeScore(name, "Safe", (RIGHT if name != "0" else MISSED,)) for name in "0123"]
    in_forms = [FormScore(UNFOUND, np.zeros(0), np.zeros(0, bool), 1, 0.0)]
    print_claim(*print_rows({"bodies given": given, "unnamed": in_forms}))
    *table, last = capsys.readouterr().out.splitlines()
    claim = json.loads(last)
    assert [line.split("  ")[0] for line in table if line] == ["", "bodies given", "", "unnamed"]
    assert claim["ours"]["ok"] == 0.75 and claim["met"] is False
    assert [(more["claim"], more["ours"]) for more in claim["more"]] == [("ok joints, unnamed", 0.0)]


def test_nothing_is_claimed_without_rows(capsys):
    print_claim({}, {})
    assert json.loads(capsys.readouterr().out)["met"] is None


@pytest.mark.parametrize("path", [QUICK, UNSEEN])
def test_the_configurations_can_be_read(path):
    assert load_config(path).ranking.sees_categories is (path == QUICK)
