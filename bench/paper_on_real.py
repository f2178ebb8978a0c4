"""Accuracy of the paper's method on joints of real objects, rigid bodies given (paper, Table 1; docs/background/metrics.md).

Every object is tested by networks that never saw it. They are trained on procedural shapes and continued on the real objects of
the other folds, as in bench/real_objects.py, with the same data and cache. The networks have the sizes of `small`, and the
paper's inputs, losses, negatives, candidates and terms. The claim is that OBB_fine is better than GNN_fine, as in the paper.

Usage:
    python bench/paper_on_real.py [--data DIR] [--cache DIR] [--count 16] [--seeds 3] [--folds 5] [--quick]
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import torch

from common import print_claims
from kinmo.config import Config, TrainingConfig, load_config
from kinmo.dataset.store import IndexEntry
from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.joint_records import ShapeScore
from kinmo.evaluation.parts_given import score_parts_given
from kinmo.experiments.table1.rule_baseline import rule_joints
from kinmo.experiments.table1.upper_bound import true_type_candidates, upper_bound
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.motion_gnn.gnn_estimate import gnn_joint
from kinmo.learning.motion_gnn.gnn_predictor import MotionGnnPredictor
from kinmo.learning.motion_gnn.gnn_training import train_motion_gnn
from kinmo.methods.paper.axis_selection.axis_selection_training import train_axis_selection
from kinmo.methods.paper.axis_selection.axis_selector import AxisSelector
from kinmo.methods.paper.leaf_roles import leaf_roles
from kinmo.methods.paper.mobility_tree import tree_with_given_bodies
from kinmo.methods.paper.refinement import Refiner
from kinmo.pipeline.evaluation.method_rows import TYPE_SETS
from real_figures import Figures, figures_of, print_figures
from real_shapes import entries_of, folds_of, gather_shapes, load_shapes, shapes_parser, split_training

Model = Literal["gnn_coarse", "gnn_fine", "axis"]
MODELS: tuple[Model, ...] = ("gnn_coarse", "gnn_fine", "axis")
PRETRAINING = {"gnn_coarse": 40, "gnn_fine": 40, "axis": 20}
FINE_TUNING = {"gnn_coarse": 15, "gnn_fine": 15, "axis": 4}
"""Epochs on procedural shapes, and on real objects, by network."""
FINE_TUNING_RATE = 0.4
"""Factor of the learning rate on real objects."""
Data = tuple[list[PreparedShape], list[PreparedShape]]
"""Training and validation shapes."""
Rows = dict[str, list[ShapeScore]]


@dataclass(frozen=True)
class Networks:
    """Training of the paper's networks with one seed. Each is kept in `folder` and trained once."""

    folder: Path
    config: Config
    seed: int

    def pretrained(self, model: Model, data: Data) -> Path:
        """Weights trained on procedural shapes."""
        return self._trained(model, "procedural", data, lambda old: replace(old, epochs=PRETRAINING[model]))

    def fine_tuned(self, model: Model, name: str, data: Data, initial: Path) -> Path:
        """Weights continued on the real objects that a fold, with this name, trains on."""

        def shorter(old: TrainingConfig) -> TrainingConfig:
            return replace(old, epochs=FINE_TUNING[model], learning_rate=FINE_TUNING_RATE * old.learning_rate)

        return self._trained(model, name, data, shorter, initial)

    def _trained(
        self,
        model: Model,
        name: str,
        data: Data,
        schedule: Callable[[TrainingConfig], TrainingConfig],
        initial: Path | None = None,
    ) -> Path:
        folder = self.folder / f"paper-{model}-{name}-{self.seed}"
        if (folder / "weights.safetensors").exists():
            return folder / "weights.safetensors"
        training, validation = data
        print(f"training {folder.name} on {len(training)} shapes", flush=True)
        if model == "axis":
            axis = replace(self.config.axis, training=schedule(self.config.axis.training))
            train_axis_selection(training, validation, axis, folder, seed=self.seed, device="cpu", initial=initial)
        else:
            gnn = replace(self.config.gnn, training=schedule(self.config.gnn.training))
            types = TYPE_SETS[0] if model == "gnn_coarse" else TYPE_SETS[1]
            train_motion_gnn(training, validation, gnn, folder, types=types, seed=self.seed, device="cpu", initial=initial)
        return folder / "weights.safetensors"


def score_rows(rows: Rows, shapes: Sequence[PreparedShape], weights: dict[Model, Path], config: Config) -> None:
    """Add the scores of the paper's four methods on some shapes, bodies given."""
    selector = AxisSelector.load(weights["axis"], "cpu")
    for types in TYPE_SETS:
        gnn = MotionGnnPredictor.load(weights["gnn_coarse" if types == "coarse" else "gnn_fine"], "cpu")
        for shape in shapes:
            tree = tree_with_given_bodies(shape, gnn.predict_edges(shape))
            refiner = Refiner(shape, config.refinement, selector)
            alone = {body: gnn_joint(estimate) for body, estimate in enumerate(tree.estimates)}
            refined = dict(alone)
            for body, (roles, estimate) in enumerate(zip(leaf_roles(shape, tree.bodies), tree.estimates, strict=True)):
                if estimate is not None:
                    refined[body] = refiner.estimates(roles, estimate)[0]
            rows.setdefault(f"GNN_{types}", []).append(score_parts_given(shape, alone))
            rows.setdefault(f"OBB_{types}", []).append(score_parts_given(shape, refined))


def score_frame(rows: Rows, shapes: Sequence[PreparedShape], config: Config) -> None:
    """Add the rows to compare with: the upper bound of the candidates, and the rule without learning."""
    for shape in shapes:
        best = upper_bound(shape, true_type_candidates(shape, None, config.refinement))
        rows.setdefault("best of the paper's candidates", []).append(score_parts_given(shape, best))
        rows.setdefault("no learning", []).append(score_parts_given(shape, rule_joints(shape)))


def loaded(workspace: Workspace, entries: Sequence[IndexEntry]) -> Data:
    """Training and validation shapes of a workspace."""
    training, validation = split_training(entries)
    return load_shapes(workspace, training), load_shapes(workspace, validation)


def main() -> int:
    """Train missing networks, print every row, and the claim last."""
    parser = shapes_parser(__doc__, "few procedural shapes, one seed, no training on real objects", count=16)
    args = parser.parse_args()
    count, folds, seeds = (6, 0, 1) if args.quick else (args.count, args.folds, args.seeds)
    torch.set_num_threads(1)
    shapes = gather_shapes(args.data, args.cache, count, workers=args.workers)
    if shapes is None:
        return print_claim({})
    entries = entries_of(shapes.real)
    real, procedural = load_shapes(shapes.real, entries), loaded(shapes.procedural, entries_of(shapes.procedural))
    print(f"{len(real)} real and {sum(map(len, procedural))} procedural shapes, {folds} folds, {seeds} seeds")
    transferred: Rows = {}
    rows: Rows = {}
    config = load_config("small")
    score_frame(transferred, real, config)
    for seed in range(seeds):
        networks = Networks(shapes.cache / "models", config, seed)
        pretrained = {model: networks.pretrained(model, procedural) for model in MODELS}
        score_rows(transferred, real, pretrained, config)
        for fold, tested in folds_of(entries, folds):
            name, data = f"fold{fold.number}", loaded(shapes.real, fold(entries))
            weights = {model: networks.fine_tuned(model, name, data, pretrained[model]) for model in MODELS}
            score_rows(rows, load_shapes(shapes.real, tested), weights, config)
    named = {f"{name}, procedural shapes alone" if "_" in name else name: found for name, found in transferred.items()}
    figures = {name: figures_of(found) for name, found in (named | rows).items()}
    print_figures(figures)
    return print_claim(figures)


def print_claim(figures: dict[str, Figures]) -> int:
    """Print the last line: the share of ok joints of OBB_fine, and of GNN_fine as its peer."""
    alone = "" if "OBB_fine" in figures else ", procedural shapes alone"
    ours, peer = (figures.get(f"{row}{alone}", {}).get("ok") for row in ("OBB_fine", "GNN_fine"))
    ratio, met = (ours / peer if peer else None, ours > peer) if ours is not None and peer is not None else (None, None)
    claim = "share of ok joints of real objects, OBB_fine compared with GNN_fine"
    print_claims({"claim": claim, "ours": ours, "peer": peer, "ratio": ratio, "goal": 1.0, "met": met})
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
