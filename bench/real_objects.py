"""Accuracy of the `kinmo` method on real objects (docs/background/metrics.md), by networks that never saw them.

The networks are trained on procedural shapes alone, or, with --continued, also on the real objects of the other folds. All
trainings are kept in the cache and made once. Real objects are needed (--data).

Rows:

    `hierarchy`, `named`, `unnamed`, `pieces`: The four forms of each object of bench/forms.py.
    `given`: Rigid bodies given.
    `hidden`: Bodies given, names hidden.
    `turned`: Bodies given, objects rotated about up, and freely with a known up.
    `categories`: Bodies given, whole categories left out of training, a fold at a time. Real objects of others are trained on.
    `families`: Procedural shapes, bodies given, each half of the families left out of training in turn. Also seen families.
    `trees`: Boosted trees on the features of candidate joints, trained on the real objects of the other folds, bodies given.
    `upper-bound`: The best candidate joint of every body.
    `shipped`: The four forms, and bodies given, by the networks that come with kinmo, which were trained on procedural shapes.

Figures of the four forms are those of bench/forms.py; they count a shape once a seed.

Usage:
    python bench/real_objects.py [--data DIR] [--cache DIR] [--count 45] [--mechanisms 1000] [--seeds 3] [--folds 5]
                                 [--rows ROW ...] [--continued] [--workers 2] [--quick]
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from common import print_claims, print_table
from forms import FORMS, FormScore, figures
from kinmo.cli.console import LineObserver
from kinmo.dataset.jobs import Failure, runner_for
from kinmo.dataset.splits import Split, split_of
from kinmo.dataset.store import IndexEntry
from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.joint_records import ShapeScore
from kinmo.evaluation.parts_given import score_parts_given
from kinmo.experiments.table1.trees_baseline import fit_trees
from kinmo.learning.model_folder import SHIPPED
from kinmo.pipeline.train_motion import TrainMotion
from kinmo.pipeline.training_forms import TrainingForms
from real_figures import Figures, figures_of, print_figures, print_overviews
from real_scores import BODIES_GIVEN, HIDDEN, TURNED, TURNED_FREELY, ObjectTest, best_candidates, score_object
from real_shapes import Fold, Shapes, entries_of, folds_of, gather_shapes, load_shapes, shapes_parser

GIVEN, *_ = BODIES_GIVEN
FORMS_OF = {**{form: (form,) for form in FORMS}, "given": (GIVEN,), "hidden": (HIDDEN,), "turned": (TURNED, TURNED_FREELY)}
"""Tested forms of each real object, by row."""
ROWS = (*FORMS_OF, "categories", "families", "trees", "upper-bound", "shipped")
QUICK_ROWS = (*FORMS_OF, "trees", "upper-bound", "shipped")
QUICK_COUNT, QUICK_FAMILIES = 6, ("dishwasher", "laptop", "safe", "stapler")
QUICK, UNSEEN = (str(Path(__file__).with_name(f"{name}.toml")) for name in ("quick", "unseen"))
"""Configurations of --quick, and of networks for unseen categories."""
GOALS = {"type": 0.96, "axis": -2.5, "axis macro": -4.0, "ok": 0.90}
"""Goals of the row `given` by figure. A negative number is an upper limit."""
Networks = tuple[Path, ...]
"""Workspaces of networks that were trained alike, one a seed."""


@dataclass(frozen=True)
class Bench:
    """Trainings and tests.

    Attributes:
        shapes: The shapes.
        config: Configuration of the networks.
        unseen_config: Configuration of those for unseen categories.
        seeds: Number of seeds.
        folds: Number of folds.
        continues: Networks of rows without trainings of their own are continued on real objects.
        workers: Number of processes.
        known: Networks that are trained, by name.
    """

    shapes: Shapes
    config: str
    unseen_config: str
    seeds: int
    folds: int
    continues: bool
    workers: int
    known: dict[str, Networks] = field(default_factory=dict)

    def procedural(self) -> Networks:
        """Networks of the procedural training shapes alone."""
        return self._trained("procedural", self.shapes.procedural, self.config)

    def continued(self, fold: Fold) -> Networks:
        """The same, continued on the real objects that a fold does not test."""
        return self._trained(f"fold{fold.number}", self.shapes.real, self.config, fold, self.procedural())

    def unseen(self, fold: Fold, *, continues: bool) -> Networks:
        """Networks of procedural, and maybe real, shapes of the categories that a fold does not test."""
        name = f"without-{fold.number}-of-{fold.folds}"
        initial = self._trained(name, self.shapes.procedural, self.unseen_config, fold)
        return self._trained(f"{name}-real", self.shapes.real, self.unseen_config, fold, initial) if continues else initial

    def _trained(
        self, name: str, data: Workspace, config: str, fold: Fold | None = None, start: Networks | None = None
    ) -> Networks:
        if name in self.known:
            return self.known[name]
        found = []
        for seed in range(self.seeds):
            folder = self.shapes.cache / "networks" / f"{name}-{seed}"
            workspace = Workspace(folder, prepared=data.prepared, select=fold)
            print(f"networks {folder.name}", flush=True)
            origin = None if start is None else Workspace(start[seed])
            TrainMotion("kinmo", workspace, config, None, seed, "cpu", self.workers, origin).run(LineObserver())
            shutil.rmtree(TrainingForms(workspace, 1).proposals_folder, ignore_errors=True)  # large, and used once
            found.append(folder)
        return self.known.setdefault(name, tuple(found))

    def scores(self, row: str) -> dict[str, list[Any]]:
        """Scores of all objects and seeds for a row, by name of the printed line."""
        found: dict[str, list[Any]] = {}
        if row == "trees":
            self._add_trees(found)
        elif row == "upper-bound":
            shapes = load_shapes(self.shapes.real, entries_of(self.shapes.real))
            found["best candidate"] = [score_parts_given(shape, best_candidates(shape)) for shape in shapes]
        else:
            tests = [(line, test) for line, some in self._tests(row) for test in some]
            results: dict[ObjectTest, Any] = {}
            for test, scores in runner_for(self.workers).run(score_object, [test for _, test in tests]):
                if isinstance(scores, Failure):
                    raise ChildProcessError(f"{test.file}: {scores.reason}")
                results[test] = scores
            for line, test in tests:
                found.setdefault(line, []).extend(results[test])
        return found

    def _add_trees(self, found: dict[str, list[Any]]) -> None:
        entries = entries_of(self.shapes.real)
        for fold, tested in folds_of(entries, self.folds):
            training, shapes = (load_shapes(self.shapes.real, some) for some in (fold(entries), tested))
            for seed in range(self.seeds):
                trees = fit_trees(training, seed=seed)
                for line, kinds_given in (("trees", False), ("trees, kinds given", True)):
                    estimates = [(shape, trees.predict(shape, kinds_given=kinds_given)) for shape in shapes]
                    found.setdefault(line, []).extend(score_parts_given(*both) for both in estimates)

    def _tests(self, row: str) -> Iterator[tuple[str, list[ObjectTest]]]:
        """Tests of a row, with the name of their printed line. Missing networks are trained."""
        real, procedural = self.shapes.real, self.shapes.procedural
        entries = entries_of(real)
        if row == "categories":
            for fold, tested in folds_of(entries, self.folds, "category"):
                yield "category left out", object_tests(real, tested, GIVEN, self.unseen(fold, continues=True))
        elif row == "families":
            unseen = [entry for entry in entries_of(procedural) if split_of(entry.id) is Split.TEST]
            for fold, tested in folds_of(unseen, 2, "category"):
                yield "family left out", object_tests(procedural, tested, GIVEN, self.unseen(fold, continues=False))
                yield "family seen", object_tests(procedural, tested, GIVEN, self.procedural())
        elif row == "shipped":
            for form in (*FORMS, GIVEN):
                yield f"{form}, shipped", object_tests(real, entries, form, (SHIPPED,))
        else:
            for form in FORMS_OF[row]:
                if self.continues:
                    for fold, tested in folds_of(entries, self.folds):
                        yield f"{form}, continued", object_tests(real, tested, form, self.continued(fold))
                else:
                    yield form, object_tests(real, entries, form, self.procedural())


def object_tests(data: Workspace, entries: Sequence[IndexEntry], form: str, networks: Networks) -> list[ObjectTest]:
    """Tests of some objects of a workspace in one form."""
    return [ObjectTest(data.prepared / entry.file, form, networks) for entry in entries]


def print_rows(rows: Mapping[str, Sequence[Any]]) -> tuple[dict[str, Figures], dict[str, dict[str, Any]]]:
    """Print and return the figures of the lines with bodies given, and of those in the forms of bench/forms.py."""
    given = {line: figures_of(scores) for line, scores in rows.items() if isinstance(scores[0], ShapeScore)}
    in_forms = {line: figures(scores) for line, scores in rows.items() if isinstance(scores[0], FormScore)}
    print()
    if given:
        print_figures(given)
    if in_forms:
        print_table(("", *next(iter(in_forms.values()))), [(line, *found.values()) for line, found in in_forms.items()])
    return given, in_forms


def main() -> int:
    """Train missing networks, print every row, and the claims last."""
    parser = shapes_parser(__doc__, "few shapes, little training, one seed, and no rows with networks of their own", count=45)
    parser.add_argument("--mechanisms", type=int, default=1000, help="procedural shapes without a category")
    parser.add_argument("--rows", nargs="+", choices=ROWS, help="rows to print (default: all)")
    parser.add_argument("--continued", action="store_true", help="continue networks on the real objects of the other folds")
    args = parser.parse_args()
    few: dict[str, Any] = {}
    if args.quick:
        args.cache, args.count, args.mechanisms, args.folds, args.seeds = args.cache / "quick", QUICK_COUNT, QUICK_COUNT, 2, 1
        few = {"families": QUICK_FAMILIES, "objects": QUICK_COUNT}
    shapes = gather_shapes(args.data, args.cache, args.count, args.mechanisms, workers=args.workers, **few)
    if shapes is None:
        return print_claim({}, {})
    config, unseen = (QUICK, QUICK) if args.quick else ("shipped", UNSEEN)
    bench = Bench(shapes, config, unseen, args.seeds, args.folds, args.continued, args.workers)
    real, procedural = (len(entries_of(data)) for data in (shapes.real, shapes.procedural))
    print(f"{real} real and {procedural} procedural shapes, {args.folds} folds, {args.seeds} seeds")
    found: dict[str, list[Any]] = {}
    given: dict[str, Figures] = {}
    in_forms: dict[str, dict[str, Any]] = {}
    for row in args.rows or (QUICK_ROWS if args.quick else ROWS):
        if row == "shipped" and not SHIPPED.exists():
            print("no networks come with this copy of kinmo: the row `shipped` is left out (make weights)")
            continue
        found |= bench.scores(row)
        given, in_forms = print_rows(found)
    if given:
        split = f"{args.folds} folds by hashed id"
        print_overviews({line: found[line] for line in given}, "PartNet-Mobility and procedural shapes", split, args.seeds)
    return print_claim(given, in_forms)


def print_claim(given: Mapping[str, Figures], in_forms: Mapping[str, Mapping[str, Any]]) -> int:
    """Print the last line: the goals of the row `given`, and the share of ok joints in each form."""
    ours = given.get(f"{GIVEN}, continued", given.get(GIVEN))
    met = None if ours is None else all(ours[name] >= goal if goal > 0 else ours[name] <= -goal for name, goal in GOALS.items())
    unknown = {"peer": None, "ratio": None}
    claims = ({"claim": f"ok joints, {line}", "ours": found["ok"], **unknown, "goal": None} for line, found in in_forms.items())
    first = {"claim": "joints of real objects, bodies given", "ours": ours, **unknown, "goal": GOALS, "met": met}
    print_claims(first, *(claim | {"met": None} for claim in claims))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
