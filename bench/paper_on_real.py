"""How well does the paper's method say the joints of real objects, bodies given? (paper, Table 1; docs/metrics.md)

    python bench/paper_on_real.py [--data DIR] [--cache DIR] [--count 16] [--seeds 3] [--folds 5] [--quick]

Every object is tested by networks that never saw it: they are trained on procedural shapes and go on with the real objects of
the other folds (`python bench/real_objects.py` does so for the `kinmo` method, and shares data and cache). The networks have
the sizes of `small` and the paper's inputs, losses, negatives, candidates and terms.

The claim at the end is that OBB_fine beats GNN_fine, as in the paper.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import torch

from kinmo.config import Config, TrainingConfig, load_config
from kinmo.evaluation.joint_records import ShapeScore
from kinmo.evaluation.parts_given import parts_given
from kinmo.experiments.table1.rows import TYPE_SETS, true_type_candidates
from kinmo.experiments.table1.rule_baseline import without_learning
from kinmo.experiments.table1.upper_bound import ceiling
from kinmo.features.part_geometry import part_geometries
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.motion_gnn.gnn_estimate import gnn_joint
from kinmo.learning.motion_gnn.gnn_predictor import MotionGnnPredictor
from kinmo.learning.motion_gnn.gnn_training import train_motion_gnn
from kinmo.methods.paper.axis_selection.axis_selector import AxisSelector
from kinmo.methods.paper.axis_selection.axis_training import train_axis_selection
from kinmo.methods.paper.mobility_tree import given_tree
from kinmo.methods.paper.refinement import Refiner
from real_figures import Figures, figures_of, print_figures
from real_shapes import Fold, gathered, parser_for, parted_by_split

Model = Literal["gnn_coarse", "gnn_fine", "axis"]
MODELS: tuple[Model, ...] = ("gnn_coarse", "gnn_fine", "axis")
PRETRAINING = {"gnn_coarse": 40, "gnn_fine": 40, "axis": 20}
FINE_TUNING = {"gnn_coarse": 15, "gnn_fine": 15, "axis": 4}
"""Epochs on procedural shapes, and on real objects."""
SLOWER = 0.4
"""Of the learning rate, on real objects."""
Rows = dict[str, list[ShapeScore]]


@dataclass(frozen=True)
class Networks:
    """Training of the paper's networks with a seed, each kept in `folder` and not trained twice."""

    folder: Path
    config: Config
    seed: int

    def pretrained(self, model: Model, shapes: Sequence[PreparedShape]) -> Path:
        """Weights trained on procedural shapes."""
        rest, kept = parted_by_split(shapes)
        return self._trained(model, "procedural", rest, kept, lambda old: replace(old, epochs=PRETRAINING[model]))

    def fine_tuned(self, model: Model, fold: Fold, initial: Path) -> Path:
        """Weights that went on with the real objects of a fold."""
        name, training, validation, _ = fold

        def shorter(old: TrainingConfig) -> TrainingConfig:
            return replace(old, epochs=FINE_TUNING[model], learning_rate=SLOWER * old.learning_rate)

        return self._trained(model, name, training, validation, shorter, initial)

    def _trained(
        self,
        model: Model,
        name: str,
        training: Sequence[PreparedShape],
        validation: Sequence[PreparedShape],
        schedule: Callable[[TrainingConfig], TrainingConfig],
        initial: Path | None = None,
    ) -> Path:
        folder = self.folder / f"paper-{model}-{name}-{self.seed}"
        if (folder / "weights.safetensors").exists():
            return folder / "weights.safetensors"
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
    """Add the scores of the paper's four rows on some shapes, their bodies given."""
    selector = AxisSelector.load(weights["axis"], "cpu")
    for types in TYPE_SETS:
        gnn = MotionGnnPredictor.load(weights["gnn_coarse" if types == "coarse" else "gnn_fine"], "cpu")
        for shape in shapes:
            tree = given_tree(shape, gnn.predict_edges(shape))
            refiner = Refiner(shape, config.refinement, selector)
            alone = {body: gnn_joint(estimate) for body, estimate in enumerate(tree.estimates)}
            refined = dict(alone)
            for body, (part, estimate) in enumerate(zip(part_geometries(shape, tree.bodies), tree.estimates, strict=True)):
                if estimate is not None:
                    refined[body] = refiner.estimates(part, estimate)[0]
            rows.setdefault(f"GNN_{types}", []).append(parts_given(shape, alone))
            rows.setdefault(f"OBB_{types}", []).append(parts_given(shape, refined))


def score_frame(rows: Rows, shapes: Sequence[PreparedShape], config: Config) -> None:
    """Add the rows that frame the table."""
    for shape in shapes:
        best = ceiling(shape, true_type_candidates(shape, None, config.refinement))
        rows.setdefault("ceiling, paper's candidates", []).append(parts_given(shape, best))
        rows.setdefault("no learning", []).append(parts_given(shape, without_learning(shape)))


def main() -> int:
    """Train what is missing, print every row, and the claim last."""
    parser = parser_for(__doc__, count=16)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--quick", action="store_true", help="few procedural shapes, one seed, no real shapes to learn from")
    args = parser.parse_args()
    count, folds, seeds = (6, 0, 1) if args.quick else (args.count, args.folds, args.seeds)
    torch.set_num_threads(1)
    shapes = gathered(args.data, args.cache, count, folds)
    if shapes is None:
        return claim({})
    print(f"{len(shapes.real)} real and {len(shapes.procedural)} procedural shapes, {folds} folds, {seeds} seeds")
    transferred: Rows = {}
    rows: Rows = {}
    config = load_config("small")
    score_frame(transferred, shapes.real, config)
    for seed in range(seeds):
        networks = Networks(shapes.cache / "models", config, seed)
        pretrained = {model: networks.pretrained(model, shapes.procedural) for model in MODELS}
        score_rows(transferred, shapes.real, pretrained, config)
        for fold in shapes.by_fold():
            score_rows(rows, fold[3], {m: networks.fine_tuned(m, fold, pretrained[m]) for m in MODELS}, config)
    named = {f"{name}, procedural shapes alone" if "_" in name else name: found for name, found in transferred.items()}
    figures = {name: figures_of(found) for name, found in (named | rows).items()}
    print_figures(figures)
    return claim(figures)


def claim(figures: dict[str, Figures]) -> int:
    """Print the last line: the share of right joints of OBB_fine, and of GNN_fine as its peer."""
    alone = "" if "OBB_fine" in figures else ", procedural shapes alone"
    ours, peer = (figures.get(f"{row}{alone}", {}).get("ok") for row in ("OBB_fine", "GNN_fine"))
    known = ours is not None and peer is not None
    line = {
        "claim": "right joints of real objects, OBB_fine over GNN_fine",
        "ours": ours,
        "peer": peer,
        "ratio": ours / peer if known and peer else None,
        "goal": 1.0,
        "met": ours > peer if known else None,
    }
    print(json.dumps(line))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
