"""Accuracy of the `kinmo` method on joints of real objects (docs/background/metrics.md).

Every object is tested by networks that never saw it. They are trained on procedural shapes and continued on the real objects of
the other folds. Everything is kept in the cache and made once. Real objects are needed (--data).

Rows:

    `given`: Rigid bodies given.
    `hierarchy`: Only the part hierarchy given, by networks and without learning.
    `hidden`: Bodies given, names hidden.
    `turned`: Bodies given, objects rotated about up, and freely with a known up.
    `transfer`: Bodies given, networks of procedural shapes alone, names shown and hidden.
    `categories`: Bodies given, whole categories left out of training, a fifth at a time.
    `families`: Procedural shapes of families left out of training, each half in turn, of two seeds. Also seen families.
    `trees`: Boosted trees on the same features, trained on real objects of the other folds. Also with the kinds given.
    `upper-bound`: The best candidate joint of every part.

For the rows `categories` and `families` networks are trained anew, also on shapes without a category (--mechanisms), and do not
see categories. `categories` has one network instead of several.

Usage:
    python bench/real_objects.py [--data DIR] [--cache DIR] [--count 60] [--seeds 3] [--folds 5] [--rows ROW ...] [--quick]
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from kinmo.methods.kinmo.body_grouping import group_into_bodies
from kinmo.methods.kinmo.moving_nodes import find_moving_nodes

from common import print_claims
from kinmo.config import Config, RankingConfig, load_config
from kinmo.core.joint import Joint
from kinmo.core.mobility import Mobility
from kinmo.core.motion_types import motion_type
from kinmo.core.normalisation import Normalisation
from kinmo.core.shape_estimate import JointEstimate, ShapeEstimate
from kinmo.evaluation.hierarchy_given import score_hierarchy_given
from kinmo.evaluation.joint_records import ShapeScore
from kinmo.evaluation.parts_given import score_parts_given
from kinmo.experiments.table1.rule_baseline import rule_prediction
from kinmo.experiments.table1.trees_baseline import fit_trees
from kinmo.features.candidate_features import CandidateFeatures
from kinmo.features.prepared_shape import PreparedShape, leaf_meshes
from kinmo.io.discover import ShapeSource
from kinmo.learning.motion_gnn.gnn_predictor import MotionGnnPredictor
from kinmo.learning.motion_gnn.gnn_training import train_motion_gnn
from kinmo.methods.kinmo.body_ranking import rank_bodies
from kinmo.methods.kinmo.kinematic_tree import build_tree
from kinmo.methods.kinmo.ranking.joint_ranker import JointRanker
from kinmo.methods.kinmo.ranking.ranking_training import train_joint_ranking
from kinmo.methods.kinmo.ranking.shape_views import body_view
from real_figures import Figures, figures_of, print_figures, print_overviews
from real_shapes import Fold, Shapes, gather_shapes, shapes_parser, split_procedural
from turned_objects import turned_shapes

ROWS = ("upper-bound", "given", "hidden", "turned", "transfer", "categories", "hierarchy", "families", "trees")
PRETRAINING: dict[str, Any] = {"epochs": 10}
"""Changes to the schedule of the ranking network, since there are many procedural shapes."""
UNSEEN: dict[str, Any] = {"dropout": 0.3, "hide_categories": 1.0}
"""Changes to the ranking network for unseen categories: what it learns of a category is of no use there."""
GOALS = {"type": 0.96, "axis": -2.5, "axis macro": -4.0, "ok": 0.90}
"""Goals of the row `given` by figure. A negative number is an upper limit."""
GNN_STRIDE, GNN_TRAINING = 4, {"epochs": 30}
"""The motion GNN learns from every fourth procedural shape, and for fewer epochs than in its configuration."""


@dataclass(frozen=True)
class Bench:
    """Training of the networks. Each is kept in the cache and trained once."""

    shapes: Shapes
    config: Config

    def pretrained(self, seed: int) -> Path:
        """Weights of the ranking network, trained on the procedural shapes of all categories."""
        return self._ranking(f"procedural-{seed}", *split_procedural(self.shapes.procedural), seed)

    def fine_tuned(self, fold: Fold, seed: int) -> Path:
        """Weights of the ranking network, continued on the real objects of a fold."""
        name, training, validation, _ = fold
        return self._ranking(f"{name}-{seed}", training, validation, seed, self.pretrained(seed))

    def seen(self, training: list[PreparedShape], validation: list[PreparedShape], seed: int) -> Path:
        """Weights of the ranking network, trained on procedural training shapes of all families."""
        return self._ranking(f"seen-{seed}", training, validation, seed)

    def unseen(self, fold: Fold, seed: int, members: int | None = None) -> Path:
        """The same, trained without the categories that the fold tests, and with the mechanisms."""
        name, training, validation, tested = fold
        unseen = {shape.category for shape in tested}
        procedural = [shape for shape in self.shapes.procedural if shape.category not in unseen] + self.shapes.mechanisms
        config = replace(self.config.ranking, members=members or self.config.ranking.members, **UNSEEN)
        initial = self._ranking(f"general-{name}-{seed}", *split_procedural(procedural), seed, config=config)
        if not training:
            return initial
        return self._ranking(f"general-{name}-{seed}-real", training, validation, seed, initial, config)

    def _ranking(
        self,
        name: str,
        training: list[PreparedShape],
        validation: list[PreparedShape],
        seed: int,
        initial: Path | None = None,
        config: RankingConfig | None = None,
    ) -> Path:
        folder = self.shapes.cache / "models" / f"ranking-{name}"
        config = config or self.config.ranking
        config = replace(config, training=replace(config.training, **PRETRAINING))
        if not (folder / "weights.safetensors").exists():
            print(f"training {folder.name} on {len(training)} shapes", flush=True)
            train_joint_ranking(training, validation, config, folder, seed=seed, device="cpu", initial=initial)
        return folder / "weights.safetensors"

    def pretrained_gnn(self) -> Path:
        """Weights of the motion GNN, trained on every fourth procedural shape of all categories."""
        return self._gnn("procedural", *(shapes[::GNN_STRIDE] for shapes in split_procedural(self.shapes.procedural)))

    def fine_tuned_gnn(self, fold: Fold) -> Path:
        """Weights of the motion GNN, continued on the real objects of a fold."""
        name, training, validation, _ = fold
        return self._gnn(name, training, validation, self.pretrained_gnn())

    def seen_gnn(self, training: list[PreparedShape], validation: list[PreparedShape]) -> Path:
        """Weights of the motion GNN, trained on every fourth procedural training shape of all families."""
        return self._gnn("seen", training[::GNN_STRIDE], validation[::GNN_STRIDE])

    def unseen_gnn(self, fold: Fold) -> Path:
        """The same, trained without the categories that the fold tests, and with the mechanisms."""
        name, training, validation, tested = fold
        unseen = {shape.category for shape in tested}
        procedural = [shape for shape in self.shapes.procedural if shape.category not in unseen] + self.shapes.mechanisms
        initial = self._gnn(f"general-{name}", *(shapes[::GNN_STRIDE] for shapes in split_procedural(procedural)))
        return self._gnn(f"general-{name}-real", training, validation, initial) if training else initial

    def _gnn(
        self, name: str, training: list[PreparedShape], validation: list[PreparedShape], initial: Path | None = None
    ) -> Path:
        """Weights of one motion GNN for all seeds."""
        folder = self.shapes.cache / "models" / f"gnn-{name}"
        if not (folder / "weights.safetensors").exists():
            config = replace(self.config.gnn, training=replace(self.config.gnn.training, **GNN_TRAINING))
            print(f"training {folder.name} on {len(training)} shapes", flush=True)
            train_motion_gnn(training, validation, config, folder, types="fine", seed=0, device="cpu", initial=initial)
        return folder / "weights.safetensors"


@dataclass(frozen=True)
class Networks:
    """The networks of the `kinmo` method: the ranking network, and the motion GNN for its prior."""

    ranker: JointRanker
    gnn: MotionGnnPredictor

    @classmethod
    def load(cls, ranking: Path, gnn: Path, hide_names: bool = False) -> Networks:
        return cls(JointRanker.load(ranking, "cpu", hide_names), MotionGnnPredictor.load(gnn, "cpu", hide_names))


def given(shape: PreparedShape, networks: Networks) -> ShapeScore:
    """Score a shape with its rigid bodies given."""
    edges = networks.gnn.predict_edges(shape)
    estimates = rank_bodies(shape, None, shape.body_leaves, networks.ranker, edges, may_rest="one")
    return score_parts_given(shape, {body: found[0] for body, found in enumerate(estimates)})


def upper_bound(shape: PreparedShape) -> ShapeScore:
    """Score the candidate joints that are nearest to the true joints."""
    mobility, boxes = shape.annotation
    features = CandidateFeatures.of(shape.candidate_features)
    view = body_view(shape, features)
    estimates = {}
    for body, true in mobility.movable():
        target = view.targets[body]
        assert true.joint is not None and target is not None
        best = features.rows(view.groups[body]).start + int(np.argmax(target))
        joint = Joint(true.joint.kind, features.directions[best], features.pivots[best])
        estimates[body] = JointEstimate(joint, motion_type(joint, boxes[body], shape.up), 1.0, source="upper bound")
    return score_parts_given(shape, estimates)


def hierarchy_given(shape: PreparedShape, networks: Networks) -> ShapeScore:
    """Score a shape with only its part hierarchy given."""
    bare = replace(shape, mobility=None, body_boxes=None, edge_labels=None, body_types={})
    meshes = leaf_meshes(ShapeSource.of(shape).read(), shape)
    edges = networks.gnn.predict_edges(bare)
    bodies = group_into_bodies(bare, find_moving_nodes(bare, networks.ranker, edges).moving, edges)
    ranked = rank_bodies(bare, meshes, bodies, networks.ranker, edges, may_rest="first")
    tree, limited = build_tree(bare, meshes, bodies, [str(index) for index in range(len(bodies))], ranked)
    frame = Normalisation(shape.center, shape.diagonal)
    estimates = tuple(tuple(frame.undo_estimate(each) for each in found) for found in limited)
    alone = tuple(found[0] for found in estimates)
    mobility = frame.undo_mobility(Mobility(tree))
    return score_hierarchy_given(shape, ShapeEstimate(shape.id, shape.category, mobility, estimates, alone, "kinmo"))


def scores(bench: Bench, row: str, seeds: int) -> dict[str, list[ShapeScore]]:
    """Scores of all objects and seeds for a row, by name of the printed line."""
    found: dict[str, list[ShapeScore]] = {}

    def add(name: str, weights: tuple[Path, Path], shapes: Sequence[PreparedShape], *, hidden: bool = False) -> None:
        networks = Networks.load(*weights, hidden)
        found.setdefault(name, []).extend(given(shape, networks) for shape in shapes)

    for seed in range(seeds):
        if row == "upper-bound":
            found.setdefault("best candidate", []).extend(upper_bound(shape) for shape in bench.shapes.real)
        elif row == "transfer":
            both = bench.pretrained(seed), bench.pretrained_gnn()
            add("procedural shapes alone", both, bench.shapes.real)
            add("procedural shapes alone, names hidden", both, bench.shapes.real, hidden=True)
        elif row == "categories":
            for fold in bench.shapes.by_category():
                both = bench.unseen(fold, seed, members=1), bench.unseen_gnn(fold)
                add("category left out", both, fold[3])
        elif row == "families":
            for fold in bench.shapes.by_half():
                networks = Networks.load(bench.unseen(fold, seed), bench.unseen_gnn(fold))
                tested = [given(shape, networks) for shape in fold[3]]
                for name in ("families never seen", f"the same, {fold[0]}"):
                    found.setdefault(name, []).extend(tested)
                unseen = {shape.category for shape in fold[3]}
                others = [given(shape, networks) for shape in bench.shapes.fresh if shape.category in unseen]
                found.setdefault("the same, fresh shapes", []).extend(others)
            training, validation, tested = bench.shapes.of_seen_families()
            both = bench.seen(training, validation, seed), bench.seen_gnn(training, validation)
            add("families seen", both, tested)
        elif row == "trees":
            for _, training, validation, tested in bench.shapes.by_fold():
                trees = fit_trees([*training, *validation], seed=seed)
                for shape in tested:
                    for name, kinds_given in (("trees", False), ("trees, kinds given", True)):
                        estimates = trees.predict(shape, kinds_given=kinds_given)
                        found.setdefault(name, []).append(score_parts_given(shape, estimates))
        else:
            for fold in bench.shapes.by_fold():
                weights, tested = (bench.fine_tuned(fold, seed), bench.fine_tuned_gnn(fold)), fold[3]
                if row == "given":
                    add("bodies given", weights, tested)
                elif row == "hidden":
                    add("bodies given, names hidden", weights, tested, hidden=True)
                elif row == "turned":
                    add("turned about up", weights, turned_shapes(tested, bench.shapes.cache / "turned-about-up", freely=False))
                    add("turned freely", weights, turned_shapes(tested, bench.shapes.cache / "turned-freely", freely=True))
                elif row == "hierarchy":
                    networks = Networks.load(*weights)
                    found.setdefault("hierarchy given", []).extend(hierarchy_given(shape, networks) for shape in tested)
                    by_rule = (score_hierarchy_given(shape, rule_prediction(shape)) for shape in tested)
                    found.setdefault("hierarchy given, no learning", []).extend(by_rule)
    return found


def main() -> int:
    """Train missing networks, print every row, and the claim last."""
    parser = shapes_parser(__doc__, "few procedural shapes, one seed, the row `given` alone", count=60)
    parser.add_argument("--seeds", type=int, default=3, help="number of seeds")
    parser.add_argument("--rows", nargs="+", choices=ROWS, default=ROWS, help="rows to print (default: all)")
    parser.add_argument("--mechanisms", type=int, default=8000, help="shapes without a category, for unseen categories")
    parser.add_argument("--fresh", type=int, default=20, help="shapes a family of another seed, for unseen families")
    args = parser.parse_args()
    count, seeds, rows = (6, 1, ("given",)) if args.quick else (args.count, args.seeds, args.rows)
    torch.set_num_threads(2)
    unseen = {"categories", "families"} & set(rows)
    fresh = args.fresh if "families" in rows else 0
    shapes = gather_shapes(args.data, args.cache, count, args.folds, args.mechanisms if unseen else 0, fresh)
    if shapes is None:
        return claim(None)
    bench = Bench(shapes, load_config("small"))
    print(f"{len(shapes.real)} real and {len(shapes.procedural)} procedural shapes, {args.folds} folds, {seeds} seeds")
    figures: dict[str, Figures] = {}
    printed: dict[str, list[ShapeScore]] = {}
    for row in rows:
        for name, found in scores(bench, row, seeds).items():
            figures[name], printed[name] = figures_of(found), found
        print_figures(figures)
    print_overviews(printed, "PartNet-Mobility and procedural shapes", f"{args.folds} folds by hashed id", seeds)
    return claim(figures.get("bodies given"))


def claim(ours: Figures | None) -> int:
    """Print the last line."""
    met = None if ours is None else all(ours[name] >= goal if goal > 0 else ours[name] <= -goal for name, goal in GOALS.items())
    print_claims({"claim": "joints of real objects", "ours": ours, "peer": None, "ratio": None, "goal": GOALS, "met": met})
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
