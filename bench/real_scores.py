"""Scores of single real objects, in any process: bodies given, or in one of the forms of bench/forms.py."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import kinmo
from forms import FORMS, FormScore, score_form
from kinmo import _core
from kinmo.core.normalisation import Normalisation
from kinmo.core.shape import Shape
from kinmo.core.shape_estimate import JointEstimate
from kinmo.dataset.store import read_prepared
from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.joint_records import ShapeScore
from kinmo.evaluation.parts_given import score_parts_given
from kinmo.experiments.table1.upper_bound import upper_bound
from kinmo.features.candidate_features import CandidateFeatures
from kinmo.features.prepared_shape import PreparedShape, leaf_meshes
from kinmo.features.shape_preparation import prepare_shape
from kinmo.io.discover import ShapeSource
from kinmo.learning.model_folder import ModelFolder
from kinmo.methods.kinmo.kinmo_method import KinmoMethod

HIDDEN, TURNED, TURNED_FREELY = "names hidden", "turned about up", "turned freely"
BODIES_GIVEN = ("bodies given", HIDDEN, TURNED, TURNED_FREELY)
"""Forms of an object with its rigid bodies given: as it is, without names, and with random rotations."""
Scores = list[ShapeScore] | list[FormScore]


@dataclass(frozen=True)
class ObjectTest:
    """A test of one object.

    Attributes:
        file: The prepared object.
        form: One of `BODIES_GIVEN`, or of the forms of bench/forms.py.
        networks: Workspaces of the networks that predict, one a seed.
    """

    file: Path
    form: str
    networks: tuple[Path, ...]


def score_object(test: ObjectTest) -> Scores:
    """Scores of an object by the networks of each seed."""
    prepared = read_prepared(test.file)
    shape = ShapeSource.of(prepared).read()
    if test.form in FORMS:
        return [_score_form(shape, test.form, networks) for networks in test.networks]
    if test.form in (TURNED, TURNED_FREELY):
        shape = turned(shape, freely=test.form == TURNED_FREELY)
        prepared = prepare_shape(shape)
    meshes = leaf_meshes(shape, prepared)
    folders = [ModelFolder(Workspace(networks).models) for networks in test.networks]
    return [_score_given(prepared, meshes, KinmoMethod(folder, "cpu", test.form == HIDDEN)) for folder in folders]


def turned(shape: Shape, *, freely: bool) -> Shape:
    """A shape with a random rotation about `up`, or any (`up` turns along). It depends on the id alone."""
    rng = np.random.default_rng(list(shape.id.encode()))
    about_up = Rotation.from_rotvec(np.array(shape.up) * rng.uniform(-np.pi, np.pi))
    return shape.rotated((Rotation.random(rng=rng) if freely else about_up).as_matrix())


def _score_form(shape: Shape, form: str, networks: Path) -> FormScore:
    with tempfile.TemporaryDirectory() as folder:
        return score_form(shape, form, kinmo.Predictor(networks, device="cpu"), Path(folder))


def _score_given(shape: PreparedShape, meshes: _core.Meshes, method: KinmoMethod) -> ShapeScore:
    frame, found = Normalisation(shape.center, shape.diagonal), method.predict_given(shape, meshes).estimates
    return score_parts_given(shape, {body: frame.estimate(ranked[0]) for body, ranked in enumerate(found)})


def best_candidates(shape: PreparedShape) -> dict[int, JointEstimate]:
    """The candidate joint of every body that is nearest to its true joint."""
    mobility, _ = shape.annotation
    features = CandidateFeatures.of(shape.candidate_features)
    candidates: dict[int, tuple[NDArray[np.float64], NDArray[np.float64]]] = {}
    for body, true in mobility.movable():
        rows = features.rows(features.group_of[shape.body_leaves[body]])
        assert true.joint is not None
        own = features.kinds[rows] == true.joint.kind.code
        candidates[body] = features.directions[rows][own], features.pivots[rows][own]
    return upper_bound(shape, candidates)
