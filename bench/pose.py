"""Poses of the parts of an articulated object, one thread: compared with NumPy and SciPy, and for exact inputs.

1. RANSAC of three parts with 1,024 pairs of points and 10,000 hypotheses a part, compared with batched NumPy. The errors of 200
   problems must not exceed NumPy's, in the median and the 95th percentile. One problem is timed.
2. Two parts with a hinge, and two with a slider, compared with SciPy's least squares. The sum of squares must be no larger.
3. Point predictions without errors, of objects with two to six parts: the largest errors of poses and joints.

Usage:
    python bench/pose.py [--quick]
"""

from __future__ import annotations

from dataclasses import dataclass

from common import Cell, Claim, best_time, budget_claim, option_parser, print_claims, print_table, ratio_claim, use_one_thread

use_one_thread()

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from kinmo import _core
from kinmo.core.joint import JointKind
from kinmo.scans.object_structure import Structure
from kinmo.scans.poses.category_prior import CategoryPrior
from kinmo.scans.poses.point_predictions import PointPredictions
from kinmo.scans.poses.pose_fitting import PoseOptions, estimate_poses
from kinmo.scans.poses.scan_estimate import ScanEstimate
from kinmo.scans.preprocessing.input_frame import InputFrame

F64 = NDArray[np.float64]
SEARCH_GOAL, JOINT_GOAL = 10.0, 100.0
"""Ratios to reach."""
PARTS, POINTS, HYPOTHESES, THRESHOLD = 3, 1024, 10_000, 0.1
"""Parts, pairs of points a part, hypotheses a part, and the largest distance of an inlier."""
SCALE, NOISE, WRONG = 0.7, 0.03, 0.4
"""True scale, noise of the points, and share of wrong pairs."""
PROBLEMS, REPEATS = 200, 20
QUICK = 5, 3
"""Problems and repeats, and those of --quick."""
POSE_GOAL, DEGREES_GOAL = 1e-4, 0.01
"""Largest errors for exact inputs, of poses and of joint directions in degrees."""
MAX_PARTS, EXACT_POINTS, EXACT_HYPOTHESES, MAX_TILT = 6, 200, 200, 0.35
"""Exact inputs: largest number of parts, points and hypotheses a part, and tilt of nearly axis-aligned joints in radians."""
EXACT_SHARE = 20
"""Exact inputs are one in this many problems."""
CHUNK = 1000
"""Hypotheses that NumPy scores at once; more do not fit the caches."""


def clouds(seed: int, slides: bool = False) -> tuple[F64, F64, list[Rotation]]:
    """Source and target points [PARTS, POINTS, 3], two of five pairs wrong, and the true rotations of the parts.

    Part 1 moves against part 0, by a hinge along x or a slider.
    """
    rng = np.random.default_rng(seed)
    base = Rotation.random(random_state=rng)
    turned = base * Rotation.from_rotvec([rng.uniform(-1.5, 1.5), 0.0, 0.0])
    turns = [base, base if slides else turned, Rotation.random(random_state=rng)]
    source = rng.uniform(-0.5, 0.5, (PARTS, POINTS, 3))
    target = np.stack([SCALE * turn.apply(points) for turn, points in zip(turns, source, strict=True)])
    target += rng.normal(scale=NOISE, size=target.shape)
    wrong = rng.random((PARTS, POINTS)) < WRONG
    target[wrong] = rng.uniform(-0.5, 0.5, (int(wrong.sum()), 3))
    return source, target, turns


def kabsch(covariances: F64) -> F64:
    """Rotations [..., 3, 3] that fit covariances [..., 3, 3] of target times source best."""
    u, _, v_t = np.linalg.svd(covariances)
    signs = np.ones(covariances.shape[:-1])
    signs[..., 2] = np.sign(np.linalg.det(u @ v_t))
    return (u * signs[..., None, :]) @ v_t


def fitted(source: F64, target: F64) -> tuple[F64, F64, F64]:
    """Rotations, scales and shifts of the least-squares similarities of pairs [..., n, 3]."""
    a, b = source - source.mean(-2, keepdims=True), target - target.mean(-2, keepdims=True)
    turns = kabsch(np.swapaxes(b, -1, -2) @ a)
    turned = a @ np.swapaxes(turns, -1, -2)
    scales = np.sum(turned * b, axis=(-1, -2)) / np.maximum(np.sum(a * a, axis=(-1, -2)), 1e-12)
    shifts = target.mean(-2) - scales[..., None] * np.einsum("...ij,...j->...i", turns, source.mean(-2))
    return turns, scales, shifts


def numpy_search(source: F64, target: F64, rng: np.random.Generator) -> tuple[F64, F64, F64]:
    """Rotation [3, 3], scale [] and shift [3] of the hypothesis with most inliers, fitted again to these."""
    best, inliers = -1, np.zeros(len(source), bool)
    for _ in range(HYPOTHESES // CHUNK):
        drawn = rng.integers(0, len(source), (CHUNK, 3))
        turns, scales, shifts = fitted(source[drawn], target[drawn])
        moved = np.einsum("hij,nj->hni", (scales[:, None, None] * turns).astype(np.float32), source.astype(np.float32))
        near = np.sum((moved + shifts[:, None].astype(np.float32) - target.astype(np.float32)) ** 2, -1) < THRESHOLD**2
        counts = near.sum(axis=1)
        if counts.max() > best:
            best, inliers = int(counts.max()), near[counts.argmax()]
    return fitted(source[inliers], target[inliers])


def degrees(found: F64, true: Rotation) -> float:
    return float(np.degrees((Rotation.from_matrix(found) * true.inv()).magnitude()))


def search(problems: int, repeats: int) -> Claim:
    """Compare RANSAC: errors over fixed problems, then times."""
    starts = np.arange(PARTS + 1, dtype=np.int64) * POINTS

    def ours(source: F64, target: F64) -> tuple[F64, ...]:
        flat = source.reshape(-1, 3), target.reshape(-1, 3)
        found, _ = _core.find_similarities(*flat, starts, hypotheses=HYPOTHESES, threshold=THRESHOLD, seed=0)
        return found

    def peer(source: F64, target: F64) -> tuple[F64, ...]:
        rng = np.random.default_rng(0)
        found = [numpy_search(a, b, rng) for a, b in zip(source, target, strict=True)]
        return tuple(np.stack(values) for values in zip(*found, strict=True))

    errors: dict[str, list[tuple[float, float, float]]] = {"kinmo": [], "NumPy": []}
    for seed in range(problems):
        source, target, right = clouds(seed)
        for name, run in (("kinmo", ours), ("NumPy", peer)):
            turns, scales, shifts = run(source, target)
            off = [degrees(turn, true) for turn, true in zip(turns, right, strict=True)]
            errors[name] += zip(off, np.linalg.norm(shifts, axis=1), abs(scales / SCALE - 1.0), strict=True)
    figures = {name: np.percentile(values, [50, 95], axis=0) for name, values in errors.items()}
    print(f"{problems} problems of {PARTS} parts")
    rows: list[tuple[Cell, ...]] = [
        (name, error, float(middle[column]), float(high[column]))
        for name, (middle, high) in figures.items()
        for column, error in enumerate(("rotation (deg)", "translation", "scale"))
    ]
    print_table(("method", "error", "median", "95th percentile"), rows)
    no_worse = bool((figures["kinmo"] <= figures["NumPy"]).all())
    source, target, _ = clouds(0)
    own, theirs = (
        1e3 * best_time(lambda: ours(source, target), repeats),
        1e3 * best_time(lambda: peer(source, target), max(1, repeats // 4)),
    )
    claim = "similarities of 3 parts x 1,024 pairs x 10,000 hypotheses compared with NumPy, ms"
    return ratio_claim(claim, ours=own, peer=theirs, goal=SEARCH_GOAL, agree=no_worse)


def joint(kind: JointKind, repeats: int) -> Claim:
    """Compare the poses of two parts with a joint: sums of squares, then times."""
    slides = kind is JointKind.PRISMATIC
    source, target, turns = clouds(1, slides)
    source, target = source[:2], target[:2]
    direction = np.array([1.0, 0.0, 0.0])
    shared = np.sqrt(0.5 * POINTS) * np.eye(3) if slides else np.sqrt(POINTS) * direction[:, None]
    starts = np.arange(3, dtype=np.int64) * POINTS
    start = np.stack([(turn * Rotation.from_rotvec([0.1, -0.1, 0.1])).as_matrix() for turn in turns[:2]])
    clouds_ = [(SCALE * (a - a.mean(0)), b - b.mean(0)) for a, b in zip(source, target, strict=True)]

    def residuals(vectors: F64) -> F64:
        found = Rotation.from_rotvec(vectors.reshape(2, 3))
        own = [(turn.apply(a) - b).ravel() for turn, (a, b) in zip(found, clouds_, strict=True)]
        tie = (found[0].as_matrix() - found[1].as_matrix()) @ shared
        return np.concatenate([*own, tie.ravel()])

    def ours() -> F64:
        pairs, kinds = np.array([[0, 1]], np.uint32), np.array([kind.code], np.uint8)
        return _core.fit_constrained_poses(
            source.reshape(-1, 3), target.reshape(-1, 3), starts, pairs, kinds, direction[None], start, np.full(2, SCALE),
            np.zeros((2, 3)), frames=np.array([0, 2]), threshold=1e3,
        )[0]  # fmt: skip

    def peer() -> F64:
        begin = Rotation.from_matrix(start).as_rotvec().ravel()
        return np.asarray(least_squares(residuals, begin, method="lm", ftol=1e-4).x)

    own_cost = np.sum(residuals(Rotation.from_matrix(ours()).as_rotvec().ravel()) ** 2)
    peer_cost = np.sum(residuals(peer()) ** 2)
    name = "a slider" if slides else "a hinge"
    print(f"sum of squares with {name}: kinmo {own_cost:.9f}, SciPy {peer_cost:.9f}")
    own, theirs = 1e3 * best_time(ours, repeats), 1e3 * best_time(peer, repeats)
    agree = bool(own_cost <= peer_cost * (1 + 1e-9))
    claim = f"two parts with {name}, 2 x 1,024 pairs, compared with SciPy, ms"
    return ratio_claim(claim, ours=own, peer=theirs, goal=JOINT_GOAL, agree=agree)


@dataclass(frozen=True, eq=False)
class Exact:
    """Point predictions of an object without errors, and its true poses and joints in the camera's frame.

    Poses are similarities of its K parts from NPCS: rotations, scales and shifts.
    """

    predictions: PointPredictions
    structure: Structure
    rotations: list[Rotation]
    scales: F64
    shifts: F64
    directions: F64
    pivots: F64


def exact_object(kinds: tuple[JointKind, ...], rng: np.random.Generator) -> Exact:
    """Parts with joints to earlier parts. Axes are random, half of them near the coordinate axes."""
    count = len(kinds) + 1
    parents = tuple(int(rng.integers(part)) for part in range(1, count))
    sizes, corners = rng.uniform(0.2, 0.6, count), rng.uniform(-0.2, 0.6, (count, 3))
    # from NAOCS to the camera, for every part
    turns, shifts = [Rotation.random(random_state=rng)], [rng.uniform(-0.3, 0.3, 3) + [0.0, 0.0, 2.0]]
    axes, pivots, seen_axes, seen_pivots = [], [], [], []
    for kind, parent in zip(kinds, parents, strict=True):
        tilted = Rotation.from_rotvec(rng.uniform(-1.0, 1.0, 3) * MAX_TILT / np.sqrt(3.0)).apply(np.eye(3)[rng.integers(3)])
        axis, pivot = (
            (tilted if rng.random() < 0.5 else Rotation.random(random_state=rng).apply(tilted)),
            rng.uniform(0.0, 1.0, 3),
        )
        turn = Rotation.from_rotvec(axis * (0.0 if kind is JointKind.PRISMATIC else rng.uniform(-1.5, 3.0)))
        slide = 0.0 if kind is JointKind.REVOLUTE else rng.uniform(-0.3, 0.5)
        seen_axes.append(turns[parent].apply(axis))
        seen_pivots.append(turns[parent].apply(pivot) + shifts[parent])
        turns.append(turns[parent] * turn)
        shifts.append(turns[parent].apply(pivot - turn.apply(pivot) + slide * axis) + shifts[parent])
        axes.append(axis)
        pivots.append(pivot)
    npcs = rng.uniform(0.2, 0.8, (count, EXACT_POINTS, 3))
    naocs = sizes[:, None, None] * npcs + corners[:, None]
    points = np.stack([turn.apply(own) + shift for turn, own, shift in zip(turns, naocs, shifts, strict=True)])
    parts = np.repeat(np.arange(count), EXACT_POINTS)
    # points of the base predict joints as well
    joint_of = np.where(parts > 0, parts, rng.integers(1, count, len(parts)))
    predictions = PointPredictions(
        InputFrame(np.zeros(3), 1.0), points.reshape(-1, 3), parts, npcs.reshape(-1, 3), sizes, corners,
        joint_of, np.array(axes)[joint_of - 1], np.array(pivots)[joint_of - 1],
    )  # fmt: skip
    placed = np.stack([turn.apply(corner) + shift for turn, corner, shift in zip(turns, corners, shifts, strict=True)])
    return Exact(predictions, Structure(kinds, parents), turns, sizes, placed, np.array(seen_axes), np.array(seen_pivots))


def exact_errors(found: ScanEstimate, right: Exact) -> tuple[float, float]:
    """Largest error of poses and pivots (radians, lengths, relative scales), and of joint directions in degrees."""
    turned = [degrees(*both) for both in zip(found.poses.rotations, right.rotations, strict=True)]
    moved = np.linalg.norm(found.poses.translations - right.shifts, axis=1)
    aside = np.linalg.norm(np.cross(found.pivots - right.pivots, right.directions), axis=1)
    poses = np.concatenate([np.radians(turned), moved, abs(found.poses.scales / right.scales - 1.0), aside])
    off = np.linalg.norm(np.cross(found.directions, right.directions), axis=1)
    return float(poses.max()), float(np.degrees(np.arcsin(off.clip(max=1.0))).max())


def exact(problems: int) -> list[Claim]:
    """Errors for exact inputs: two to six parts, joints of one kind and of all kinds, with and without a category prior."""
    rng, every = np.random.default_rng(0), list(JointKind)
    worst, count, options = np.zeros(2), 0, PoseOptions(hypotheses=EXACT_HYPOTHESES)
    for parts in range(2, MAX_PARTS + 1):
        for some in (*([kind] for kind in every), every):
            for _ in range(problems):
                kinds = tuple(some[index] for index in rng.integers(0, len(some), parts - 1))
                right = exact_object(kinds, rng)
                known = CategoryPrior(np.tile([0.0, 1.5], (parts - 1, 1)), np.ones(parts, bool), np.ones(parts - 1, bool))
                for prior in (None, known):
                    (found,) = estimate_poses([right.predictions], right.structure, options, prior)
                    worst = np.maximum(worst, exact_errors(found, right))
                    count += 1
    print(f"{count} objects with exact predictions")
    names, goals = ("poses", "joint directions (deg)"), (POSE_GOAL, DEGREES_GOAL)
    print_table(("", "largest error"), list(zip(names, worst.tolist(), strict=True)))
    return [
        budget_claim(f"largest error of {name} from exact predictions", largest, goal)
        for name, largest, goal in zip(names, worst.tolist(), goals, strict=True)
    ]


def main() -> None:
    """Run all comparisons."""
    quick = option_parser(__doc__, "few problems and repeats").parse_args().quick
    problems, repeats = QUICK if quick else (PROBLEMS, REPEATS)
    claims = [search(problems, repeats), joint(JointKind.REVOLUTE, repeats), joint(JointKind.PRISMATIC, repeats)]
    rows = [(claim["claim"], claim["ours"], claim["peer"], claim["ratio"]) for claim in claims]
    print_table(("task", "kinmo", "peer", "ratio"), rows)
    print_claims(*claims, *exact(max(1, problems // EXACT_SHARE)))


if __name__ == "__main__":
    main()
