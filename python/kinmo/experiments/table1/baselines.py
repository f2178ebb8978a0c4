"""All rows of Table 1 that need no trained method: upper bounds, the rule without learning, boosted trees."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from kinmo import _core
from kinmo.config import RefinementConfig
from kinmo.core.joint import joint_from_data, joint_to_data
from kinmo.core.motion_types import MotionType
from kinmo.core.shape_estimate import JointEstimate
from kinmo.core.typed_tables import to_table
from kinmo.dataset.cache import Cache, cache_key
from kinmo.dataset.shape_dataset import fingerprint, open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.stage import Observer
from kinmo.dataset.store import IndexEntry
from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.hierarchy_given import score_hierarchy_given
from kinmo.evaluation.joint_records import ShapeScore
from kinmo.evaluation.parts_given import score_parts_given
from kinmo.experiments.table1.rule_baseline import rule_joints, rule_prediction
from kinmo.experiments.table1.trees_baseline import fit_trees, library_version
from kinmo.experiments.table1.upper_bound import true_type_candidates, upper_bound
from kinmo.features.prepared_shape import PreparedShape
from kinmo.pipeline.evaluation.evaluation_folder import test_shapes

UPPER_BOUND, NO_LEARNING, TREES = "upper bound", "no learning", "trees"  # names of the rows, or their beginnings
SEEDS = 1 << 32  # number of seeds that scikit-learn accepts
MAX_TRAINING_SHAPES = 1000  # shapes that the trees are trained on at most
ALL_CANDIDATES: tuple[Literal["boxes", "contact", "symmetry"], ...] = ("boxes", "contact", "symmetry")
"""Candidates beyond the paper's."""


@dataclass(frozen=True)
class PaperBaselines:
    """The baseline rows (`pipeline.evaluation.shape_evaluation.Baselines`)."""

    refinement: RefinementConfig = field(default_factory=RefinementConfig)  # the paper's candidates
    seed: int = 0  # of the trees

    @property
    def settings(self) -> Mapping[str, Any]:
        """Everything but the trees' predictions that the scores depend on."""
        return {"refinement": to_table(self.refinement), "trees": library_version(), "seed": self.seed}

    def prepare(self, workspace: Workspace, observer: Observer) -> Mapping[str, Any]:
        """Predictions of boosted trees for every test shape, by its file; empty without scikit-learn or joints to learn from.

        The trees are trained on the same shapes as the networks. Evaluations of single categories share the predictions.
        """
        dataset = open_dataset(workspace)
        training, tests = _spread(dataset.labelled[Split.TRAIN], MAX_TRAINING_SHAPES), test_shapes(dataset)
        if not any(entry.joint_count for entry in training):
            observer.note("no row of boosted trees: no labelled training shape has a joint")
            return {}
        cache = Cache(workspace.evaluation)
        key = cache_key(training=fingerprint(training), tests=fingerprint(tests), seed=self.seed, trees=library_version())
        if cache.is_current(TREES, key):
            known: Mapping[str, Any] = cache.data(TREES)
            return known
        try:
            trees = fit_trees(map(dataset.store.load, training), seed=self.seed % SEEDS)
        except ImportError as error:
            observer.note(str(error))
            return {}
        found = {}
        for done, entry in enumerate(tests, start=1):
            estimates = trees.predict(dataset.store.load(entry))
            found[entry.file] = {str(body): estimate_to_data(estimate) for body, estimate in estimates.items()}
            observer.progress("predicting with boosted trees", done, len(tests), entry.id)
        cache.store(TREES, key, data=found)
        return found

    def score(
        self, truth: PreparedShape, meshes: _core.Meshes, data: Any
    ) -> tuple[dict[str, ShapeScore], dict[str, ShapeScore]]:
        """Scores by row, parts given and hierarchy given; `data` are predictions of the trees, None without their row."""
        every = replace(self.refinement, extra=ALL_CANDIDATES, contact_pivots="revolute")
        estimates = {
            f"{UPPER_BOUND}, paper's candidates": upper_bound(truth, true_type_candidates(truth, meshes, self.refinement)),
            f"{UPPER_BOUND}, all candidates": upper_bound(truth, true_type_candidates(truth, meshes, every)),
            NO_LEARNING: rule_joints(truth),
        }
        if data is not None:
            estimates[TREES] = {int(body): estimate_from_data(found) for body, found in data.items()}
        given = {name: score_parts_given(truth, found) for name, found in estimates.items()}
        # an upper bound over candidates of the true bodies holds in either setting
        predicted = {name: score for name, score in given.items() if name.startswith(UPPER_BOUND)}
        predicted[NO_LEARNING] = score_hierarchy_given(truth, rule_prediction(truth))
        return given, predicted


def _spread(entries: Sequence[IndexEntry], most: int) -> Sequence[IndexEntry]:
    """Some of the entries, `most` or fewer, evenly spread over all."""
    return entries[:: max(1, -(-len(entries) // most))]


def estimate_to_data(estimate: JointEstimate) -> dict[str, Any]:
    """A prediction of the trees as plain data."""
    joint = None if estimate.joint is None else joint_to_data(estimate.joint)
    return {"type": estimate.type.name, "score": float(estimate.score), "joint": joint}


def estimate_from_data(data: Mapping[str, Any]) -> JointEstimate:
    """The prediction that `estimate_to_data` took apart."""
    joint = None if data["joint"] is None else joint_from_data(data["joint"])
    return JointEstimate(joint, MotionType[data["type"]], data["score"], source=TREES)
