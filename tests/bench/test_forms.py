"""Scores on four forms of the same objects."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from articulated import shape_of_boxes
from exports import write_partnet_mobility

import forms
import kinmo
from kinmo.core.errors import InputError
from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from kinmo.core.motion_types import MotionType
from kinmo.core.shape import Mesh
from kinmo.core.shape_estimate import JointEstimate, PredictionProvenance, ShapeEstimate

HINGE = Joint(JointKind.REVOLUTE, np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]), 0.0, 1.5)
SLIDE = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3), 0.0, 0.6)
BODY, DOOR, KNOB = ((0.0, 0.0, 0.0), (1.0, 2.0, 1.0)), ((0.0, 0.0, 1.01), (1.0, 2.0, 1.1)), ((0.8, 0.9, 1.12), (0.9, 1.1, 1.2))


def cupboard():
    """A box with a door that has a knob."""
    bodies = [Body(0, "body", (1,)), Body(1, "door", (2, 3), 0, HINGE)]
    return shape_of_boxes([BODY, DOOR, KNOB], bodies, shape_id="cupboard", category="Safe", names={2: "door", 3: "knob"})


def drawer_box():
    """A box with a front that slides out and is flush with it: nothing lies between their surfaces."""
    front = ((0.0, 0.0, 1.0), (1.0, 2.0, 1.5))
    bodies = [Body(0, "body", (1,)), Body(1, "front", (2,), 0, SLIDE)]
    shape = shape_of_boxes([BODY, front], bodies, shape_id="drawer", category="Box")
    return replace(shape, parts=tuple(replace(part, mesh=part.mesh and open_at_front(part.mesh)) for part in shape.parts))


def open_at_front(mesh):
    """The mesh without its faces in the plane z = 1."""
    return Mesh(mesh.vertices, mesh.faces[np.ptp(mesh.triangles[:, :, 2], axis=1) + abs(mesh.triangles[:, 0, 2] - 1.0) > 0.0])


class Stub:
    """Predicts that the largest part is the base and all others are doors with the true hinge."""

    def __init__(self, joint=HINGE, probability=0.8):
        self.joint, self.probability, self.seen = joint, probability, []

    def predict(self, shape):
        self.seen.append(shape)
        base, *others = sorted(shape.leaves, key=lambda leaf: -shape.leaf_mesh(leaf).face_areas.sum())
        bodies = (Body(0, "base", (base,)), Body(1, "lid", tuple(sorted(others)), 0, self.joint))
        guess = JointEstimate(self.joint, MotionType.R_V_S, self.probability)
        rest = replace(guess, joint=None)
        mobility = replace(cupboard().mobility, bodies=bodies)
        estimate = ShapeEstimate(shape.id, "", mobility, ((rest,), (guess,)), (rest, guess), "stub")
        return kinmo.Prediction(shape, estimate, PredictionProvenance())


def test_forms_hide_what_they_say():
    truth = cupboard()
    named, unnamed, pieces = (forms.form_of(truth, form, 0) for form in ("named", "unnamed", "pieces"))
    assert [part.name for part in named.parts[1:]] == ["part 0_0", "door_1", "knob_2"]
    assert {part.name for part in unnamed.parts[1:]} == {"part_0", "part_1", "part_2"}
    assert len(pieces.leaves) == 3
    assert forms.form_of(truth, "hierarchy", 0) is truth
    assert {shape.category for shape in (named, unnamed, pieces)} == {""}


def test_the_order_of_parts_depends_on_the_seed_alone():
    truth = cupboard()
    sizes = [
        [len(mesh.faces) * mesh.face_areas.sum() for mesh in forms.form_of(truth, "unnamed", seed).meshes()]
        for seed in (0, 0, *range(1, 6))
    ]
    assert sizes[0] == sizes[1] and len({tuple(row) for row in sizes}) > 1


@pytest.mark.parametrize("form", forms.FORMS)
def test_a_right_prediction_is_ok_in_every_form(form, tmp_path):
    stub = Stub()
    scored = forms.score_form(cupboard(), form, stub, tmp_path)
    assert scored.is_ok.tolist() == [True] and scored.probabilities.tolist() == [0.8]
    assert scored.score.parts[0].range_iou == pytest.approx(1.0)
    assert stub.seen[0].mobility is None
    assert scored.expressible == 1
    assert scored.rand_index == 1.0


def test_a_wrong_joint_is_found_and_not_ok(tmp_path):
    scored = forms.score_form(cupboard(), "named", Stub(SLIDE), tmp_path)
    assert scored.score.parts[0].found and scored.is_ok.tolist() == [False]


def test_pieces_that_join_bodies_express_none(tmp_path):
    scored = forms.score_form(drawer_box(), "pieces", Refusing(), tmp_path)
    assert (scored.expressible, len(scored.score.parts)) == (0, 1)


class Refusing:
    """Predicts nothing."""

    def predict(self, shape):
        raise InputError(shape.id, "no")


def test_an_object_without_prediction_is_missing(tmp_path):
    scored = forms.score_form(cupboard(), "hierarchy", Refusing(), tmp_path)
    found = forms.figures([scored])
    assert (scored.score.status, found["found"], found["ok"], found["predicted"], found["ECE"]) == (
        "missing",
        0.0,
        0.0,
        0,
        None,
    )


def test_calibration_compares_probability_and_share():
    probabilities, is_ok = np.repeat([0.2, 0.9], 10), np.repeat([False, True], 10)
    assert forms.calibration_error(probabilities, is_ok, bins=2) == pytest.approx(0.15)
    assert forms.calibration_error(np.array([1.0]), np.array([True])) == 0.0


def test_the_fitted_calibration_makes_too_sure_probabilities_right():
    rng = np.random.default_rng(0)
    logits = rng.normal(size=4000)
    is_ok = rng.random(4000) < 1.0 / (1.0 + np.exp(-logits))
    slope, offset = forms.fitted_calibration(1.0 / (1.0 + np.exp(-(2.0 * logits + 1.0))), is_ok)
    assert (slope, offset) == pytest.approx((0.5, -0.5), abs=0.15)


def test_selection_keeps_the_most_probable():
    probabilities, is_ok = np.array([0.9, 0.1, 0.8, 0.2]), np.array([True, False, True, False])
    assert forms.selective_accuracy(probabilities, is_ok, 0.5) == 1.0
    assert forms.selective_accuracy(probabilities, is_ok, 1.0) == 0.5


def test_the_report_has_all_forms_and_categories(tmp_path, capsys):
    for shape in (cupboard(), drawer_box()):
        write_partnet_mobility(shape, shape.mobility, tmp_path / shape.id)
    shapes = forms.truths(tmp_path, None)
    result = forms.report(forms.score_forms(shapes, forms.FORMS, Stub()))
    assert set(result) == set(forms.FORMS)
    assert result["named"]["categories"]["Safe"]["ok"] == 1.0 and result["named"]["categories"]["Box"]["ok"] == 0.0
    assert result["named"]["all"]["found"] == 1.0 and result["named"]["all"]["ok"] == 0.5
    assert result["pieces"]["all"]["best"] == 0.5
    forms.print_report(result)
    assert capsys.readouterr().out.count("unnamed") == 3


def test_a_limit_spreads_over_the_ids(tmp_path):
    for number in range(5):
        shape = replace(cupboard(), id=f"shape-{number}")
        write_partnet_mobility(shape, shape.mobility, tmp_path / shape.id)
    assert [shape.id for shape in forms.truths(tmp_path, 3)] == ["shape-0", "shape-2", "shape-4"]


def test_a_folder_without_shapes_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"mobility_v2\.json"):
        forms.truths(tmp_path, None)
