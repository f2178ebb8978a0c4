"""Accuracy on four forms of the same objects: how predictions depend on what a user's file tells about its parts.

The objects are annotated shapes in the layout of PartNet-Mobility. Each is predicted in four forms, with its joints hidden:

    hierarchy   the tree of parts with names
    named       a flat list of the leaves with their names
    unnamed     a flat list of the leaves in random order, called part_0, part_1, ...
    pieces      the loose pieces of all triangles together, divided at creases, in random order and without names

A fifth form, `cyrillic`, is `named` with the names written in Cyrillic letters: words that no network has seen. It is predicted
only where --forms lists it.

Categories are known in the first form only. Predictions are exported as URDF and scored as `kinmo eval FILES` does it
(docs/background/metrics.md, "URDF files"): `found` and `ok` are shares of all true joints, `precision` of the predicted bodies
that move. `best` is the share of movable bodies that the parts of a form can express. It is below 1 where a patch joins a
body to its neighbours. `ARI` is the adjusted Rand index of the predicted bodies against the true ones, over the leaves of each
object, averaged over the objects; bodies that are fixed to each other count as one. `ECE` is the expected calibration error of
predicted joints in ten bins of equal count. `ok 50` and `ok 80` are the shares of ok joints among the most probable 50 % and
80 %. The line below the tables tells how the logits of the probabilities would have to change to fit these objects best
(`ranking.score_slope` and `score_offset`).

Usage:
    python bench/forms.py DATA [--model WORKSPACE] [--forms NAME ...] [--limit N] [--json FILE] [--quick]
"""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

from common import option_parser, print_claims, print_table, use_one_thread

use_one_thread()
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from sklearn.metrics import adjusted_rand_score

import kinmo
from kinmo.core.errors import InputError
from kinmo.core.mobility import Mobility
from kinmo.core.shape import Shape
from kinmo.core.shape_forms import FlatPart, flat_parts, flat_shape, in_pieces, without_names
from kinmo.evaluation.aggregate import figure_sums, ratios
from kinmo.evaluation.urdf_scoring import score_urdf
from kinmo.evaluation.urdf_scoring.urdf_figures import FIGURES
from kinmo.evaluation.urdf_scoring.urdf_scores import ObjectScore
from kinmo.io.discover import discover
from kinmo.io.readers import PARTNET_MOBILITY
from kinmo.io.readers.partnet_annotation import check_annotated
from kinmo.io.writers import ExportOptions, export
from kinmo.methods.kinmo.grouping.leaf_graph import rigid_carriers

QUICK = 3
PIECES = "pieces"
CYRILLIC = str.maketrans("abcdefghijklmnopqrstuvwxyz", "абцдефгхийклмнопярстувшжыз")
BARE = ExportOptions(collision="none")
BINS = 10
"""Bins of the calibration error."""
COLUMNS = {"recall": "found", "type": "type", "ok": "ok", "precision": "precision", "range_iou": "range IoU"}
"""Titles of the figures in the table, by their keys in `kinmo.evaluation.urdf_scoring.urdf_figures`."""
Parts = Callable[[list[FlatPart], np.random.Generator], list[FlatPart]]


class AnyPredictor(Protocol):
    """Anything that predicts as `kinmo.Predictor` does."""

    def predict(self, shape: Shape) -> kinmo.Prediction: ...


def _numbered(parts: list[FlatPart], rng: np.random.Generator) -> list[FlatPart]:
    """The parts with a number after each name: nodes of a file need different names."""
    return [replace(part, name=f"{part.name}_{number}") for number, part in enumerate(parts)]


def _in_cyrillic(parts: list[FlatPart], rng: np.random.Generator) -> list[FlatPart]:
    """The numbered parts with every letter of a name replaced by one of another script."""
    return [replace(part, name=part.name.lower().translate(CYRILLIC)) for part in _numbered(parts, rng)]


FLAT_FORMS: dict[str, Parts] = {
    "named": _numbered,
    "unnamed": without_names,
    PIECES: lambda parts, rng: without_names(in_pieces(parts), rng),
    "cyrillic": _in_cyrillic,
}
FORMS = ("hierarchy", "named", "unnamed", PIECES)
"""The forms of every table."""
ALL_FORMS = ("hierarchy", *FLAT_FORMS)


def form_of(shape: Shape, form: str, seed: int) -> Shape:
    """An annotated shape in one of `ALL_FORMS`, with its annotation. The order of parts depends on the seed and the id only."""
    if form == "hierarchy":
        return shape
    rng = np.random.default_rng([seed, *shape.id.encode()])
    return replace(flat_shape(shape, FLAT_FORMS[form](flat_parts(shape), rng)), category="")


@dataclass(frozen=True, eq=False)
class FormScore:
    """One object in one form.

    Attributes:
        score: Its joints, scored; the id and the category are those of the truth.
        probabilities: [J], the probability of each predicted joint.
        is_ok: [J], True for predicted joints that are ok.
        expressible: Number of movable bodies that the parts of the form can express.
        rand_index: Adjusted Rand index of the predicted bodies.
    """

    score: ObjectScore
    probabilities: NDArray[np.float64]
    is_ok: NDArray[np.bool_]
    expressible: int
    rand_index: float


def score_form(truth: Shape, form: str, predictor: AnyPredictor, folder: Path, seed: int = 0) -> FormScore:
    """Predict and score one object in one form.

    Args:
        truth: The annotated shape.
        form: One of `ALL_FORMS`.
        predictor: The predictor.
        folder: An empty folder for the exported prediction.
        seed: Seed of the order of parts.

    Returns:
        The scores. An object that cannot be predicted or exported is missing.

    Raises:
        InputError: The truth cannot be scored against.
    """
    shown = form_of(truth, form, seed)
    joints: tuple[kinmo.PredictedJoint, ...] = ()
    urdf: Path | None = None
    bodies = Mobility(())
    try:
        prediction = predictor.predict(replace(shown, mobility=None))
        urdf, joints = prediction.export(folder / "predicted", ["urdf"], collision="none")["urdf"], prediction.joints
        bodies = prediction.estimate.mobility
    except (InputError, ValueError) as error:
        print(f"{truth.id}, {form}: no prediction: {error}", file=sys.stderr)
    scored = score_urdf(truth, urdf, folder)
    ok_links = {part.link for part in scored.parts if part.is_ok}
    probabilities = np.array([joint.score for joint in joints], float)
    is_ok = np.array([joint.name in ok_links for joint in joints], bool)
    best = _expressible(truth, shown, form, folder / "best")
    assert shown.mobility is not None
    rand_index = adjusted_rand_score(_owners(shown, shown.mobility), _owners(shown, bodies))
    return FormScore(scored, probabilities, is_ok, best, float(rand_index))


def _owners(shape: Shape, mobility: Mobility) -> NDArray[np.int64]:
    """The rigid body of every leaf, or -1."""
    carriers = rigid_carriers(mobility)
    owner = {leaf: carriers[index] for index, body in enumerate(mobility.bodies) for leaf in body.leaves}
    return np.array([owner.get(leaf, -1) for leaf in shape.leaves], np.int64)


def _expressible(truth: Shape, shown: Shape, form: str, folder: Path) -> int:
    """Number of movable bodies that the parts of a form can express.

    Leaves never belong to two bodies. A patch may join several: the true joints of the pieces are scored to find out.
    """
    assert truth.mobility is not None and shown.mobility is not None
    if form != PIECES:
        return sum(1 for _ in truth.mobility.movable())
    return sum(
        part.found for part in score_urdf(truth, export(shown, shown.mobility, folder, ["urdf"], BARE)["urdf"], folder).parts
    )


def calibration_error(probabilities: NDArray[np.float64], is_ok: NDArray[np.bool_], bins: int = BINS) -> float | None:
    """Expected calibration error: the mean over bins of equal count of |mean probability - share of ok joints|.

    Args:
        probabilities: [J], in [0, 1].
        is_ok: [J].
        bins: Number of bins. With fewer joints, each is a bin.

    Returns:
        The error in [0, 1], weighted by the number of joints in each bin. None without joints.
    """
    if not len(probabilities):
        return None
    order = np.argsort(probabilities, kind="stable")
    groups = np.array_split(order, min(bins, len(order)))
    gaps = [len(group) * abs(probabilities[group].mean() - is_ok[group].mean()) for group in groups]
    return float(sum(gaps) / len(order))


def fitted_calibration(probabilities: NDArray[np.float64], is_ok: NDArray[np.bool_]) -> tuple[float, float]:
    """Slope and offset of the logits of probabilities [J] that fit whether joints are ok best (least cross-entropy)."""
    inside = np.clip(probabilities, 1e-6, 1.0 - 1e-6)
    logits = np.log(inside / (1.0 - inside))

    def loss(values: NDArray[np.float64]) -> float:
        signed = np.where(is_ok, 1.0, -1.0) * (values[0] * logits + values[1])
        return float(np.logaddexp(0.0, -signed).sum())

    slope, offset = minimize(loss, np.array([1.0, 0.0]), method="Nelder-Mead").x
    return float(slope), float(offset)


def selective_accuracy(probabilities: NDArray[np.float64], is_ok: NDArray[np.bool_], share: float) -> float | None:
    """Share of ok joints among the most probable `share` of the joints. None without joints."""
    if not len(probabilities):
        return None
    kept = np.argsort(-probabilities, kind="stable")[: max(1, round(share * len(probabilities)))]
    return float(is_ok[kept].mean())


def figures(scores: Sequence[FormScore]) -> dict[str, Any]:
    """Figures over some objects of one form, as plain data for JSON."""
    sums = figure_sums([each.score for each in scores], FIGURES).sum(axis=0)
    values = dict(zip((figure.key for figure in FIGURES), ratios(sums).tolist(), strict=True))
    probabilities = np.concatenate([np.zeros(0), *(each.probabilities for each in scores)])
    is_ok = np.concatenate([np.zeros(0, bool), *(each.is_ok for each in scores)])
    joints = sum(len(each.score.parts) for each in scores)
    counts = {"objects": len(scores), "joints": joints, "predicted": len(probabilities)}
    shares = {COLUMNS[key]: None if np.isnan(values[key]) else values[key] for key in COLUMNS}
    return {
        **counts,
        "best": sum(each.expressible for each in scores) / joints if joints else None,
        **shares,
        "ARI": float(np.mean([each.rand_index for each in scores])),
        "ECE": calibration_error(probabilities, is_ok),
        "ok 50": selective_accuracy(probabilities, is_ok, 0.5),
        "ok 80": selective_accuracy(probabilities, is_ok, 0.8),
    }


def truths(data: Path, limit: int | None) -> list[Shape]:
    """The annotated shapes below a folder with at least one joint, at most `limit`, which are evenly spread over the ids.

    Raises:
        InputError: There is none, or a file is wrong.
    """
    sources = sorted((found for found in discover(data) if found.layout == PARTNET_MOBILITY), key=lambda found: found.id)
    if limit is not None and limit < len(sources):
        sources = [sources[place] for place in np.linspace(0, len(sources) - 1, limit).round().astype(int)]
    shapes = []
    for source in sources:
        check_annotated(source.path)
        shapes.append(source.read())
    shapes = [shape for shape in shapes if shape.mobility is not None and any(shape.mobility.movable())]
    if not shapes:
        raise InputError(data, "expected folders with a mobility_v2.json that has joints")
    return shapes


def score_forms(
    shapes: Sequence[Shape], forms: Sequence[str], predictor: AnyPredictor, seed: int = 0
) -> dict[str, list[FormScore]]:
    """Scores of all objects by form, with progress on stderr."""
    scores: dict[str, list[FormScore]] = {form: [] for form in forms}
    for done, truth in enumerate(shapes, start=1):
        for form in forms:
            with tempfile.TemporaryDirectory() as folder:
                scores[form].append(score_form(truth, form, predictor, Path(folder), seed))
        print(f"\r{done} of {len(shapes)} objects", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    return scores


def report(scores: Mapping[str, Sequence[FormScore]]) -> dict[str, Any]:
    """Figures of each form: over all objects under "all", and by category under "categories"."""
    result: dict[str, Any] = {}
    for form, own in scores.items():
        names = sorted({each.score.category for each in own})
        by_category = {name: figures([each for each in own if each.score.category == name]) for name in names}
        result[form] = {"all": figures(own), "categories": by_category}
    return result


def print_report(result: Mapping[str, Any]) -> None:
    """Print a table over all objects by form, and one by category and form."""
    rows = [("all", form, *found["all"].values()) for form, found in result.items()]
    for category in next(iter(result.values()))["categories"]:
        rows += [(category, form, *found["categories"][category].values()) for form, found in result.items()]
    head = ("category", "form", *next(iter(result.values()))["all"])
    print_table(head, rows[: len(result)])
    print()
    print_table(head, rows[len(result) :])


def main() -> int:
    """Predict and score all objects, and print the tables."""
    parser = option_parser(__doc__, f"{QUICK} objects only")
    names = f"forms: {', '.join(ALL_FORMS)} (default: {', '.join(FORMS)})"
    parser.add_argument("data", type=Path, help="folder of annotated shapes in the layout of PartNet-Mobility")
    parser.add_argument("--model", type=Path, default=Path("workspace"), help="workspace with trained networks")
    parser.add_argument("--forms", nargs="+", choices=ALL_FORMS, default=FORMS, metavar="NAME", help=names)
    parser.add_argument("--limit", type=int, help="number of objects, evenly spread over the ids (default: all)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the order of parts (default 0)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures to a file")
    args = parser.parse_args()
    try:
        shapes = truths(args.data, QUICK if args.quick else args.limit)
        scores = score_forms(shapes, args.forms, kinmo.Predictor(args.model), args.seed)
        result = report(scores)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    print_report(result)
    every = [each for own in scores.values() for each in own]
    probabilities, is_ok = (np.concatenate([getattr(each, name) for each in every]) for name in ("probabilities", "is_ok"))
    slope, offset = fitted_calibration(probabilities, is_ok)
    print(f"\nscores would fit best with a slope of {slope:.3f} and an offset of {offset:.3f} of their logits")
    if args.json is not None:
        args.json.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    ok = {form: found["all"]["ok"] for form, found in result.items()}
    first, *others = (
        {"claim": f"ok joints, {form}", "ours": value, "peer": None, "ratio": None, "goal": None, "met": None}
        for form, value in ok.items()
    )
    print_claims(first, *others)
    return 0


if __name__ == "__main__":
    sys.exit(main())
