"""Poses of the parts of an articulated object, one thread: RANSAC against batched NumPy, joints against SciPy's least squares.

    RAYON_NUM_THREADS=1 OMP_NUM_THREADS=1 python bench/pose.py [--quick]

Three parts with 1,024 pairs of points each and 10,000 hypotheses a part, in 200 problems of which one is timed; then two parts
on a revolute joint, the same sum of squares. First checks that neither peer has the better result: in the median and the 95th
percentile of the errors no difference that the problems can tell from none (paired bootstrap, 95 %).
"""

from __future__ import annotations

import os

for variable in ("RAYON_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import argparse
import json
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from kinmo import _core

F64 = NDArray[np.float64]
SEARCH_GOAL, JOINT_GOAL = 10.0, 100.0
PARTS, POINTS, HYPOTHESES, THRESHOLD = 3, 1024, 10_000, 0.1
SCALE, NOISE, WRONG = 0.7, 0.03, 0.4
PROBLEMS, REPEATS, DRAWS = 200, 20, 1000
QUICK = 5, 3
CHUNK = 1000
"""Hypotheses that NumPy scores at once: more do not fit its caches."""


def clouds(seed: int) -> tuple[F64, F64, list[Rotation]]:
    """Pairs [PARTS, POINTS, 3] of points, two of five wrong, and the true turns; part 1 hangs on part 0 by a hinge along x."""
    rng = np.random.default_rng(seed)
    base = Rotation.random(random_state=rng)
    turns = [base, base * Rotation.from_rotvec([rng.uniform(-1.5, 1.5), 0.0, 0.0]), Rotation.random(random_state=rng)]
    source = rng.uniform(-0.5, 0.5, (PARTS, POINTS, 3))
    target = np.stack([SCALE * turn.apply(points) for turn, points in zip(turns, source, strict=True)])
    target += rng.normal(scale=NOISE, size=target.shape)
    wrong = rng.random((PARTS, POINTS)) < WRONG
    target[wrong] = rng.uniform(-0.5, 0.5, (int(wrong.sum()), 3))
    return source, target, turns


def kabsch(covariances: F64) -> F64:
    """Turns [..., 3, 3] that fit covariances [..., 3, 3] of target times source best."""
    u, _, v_t = np.linalg.svd(covariances)
    signs = np.ones(covariances.shape[:-1])
    signs[..., 2] = np.sign(np.linalg.det(u @ v_t))
    return (u * signs[..., None, :]) @ v_t


def fitted(source: F64, target: F64) -> tuple[F64, F64, F64]:
    """Turns, scales and shifts of the least-squares similarities of pairs [..., n, 3]."""
    a, b = source - source.mean(-2, keepdims=True), target - target.mean(-2, keepdims=True)
    turns = kabsch(np.swapaxes(b, -1, -2) @ a)
    turned = a @ np.swapaxes(turns, -1, -2)
    scales = np.sum(turned * b, axis=(-1, -2)) / np.maximum(np.sum(a * a, axis=(-1, -2)), 1e-12)
    shifts = target.mean(-2) - scales[..., None] * np.einsum("...ij,...j->...i", turns, source.mean(-2))
    return turns, scales, shifts


def numpy_search(source: F64, target: F64, rng: np.random.Generator) -> tuple[F64, F64, F64]:
    """The turn [3, 3], scale [] and shift [3] of the hypothesis with most inliers, fitted anew to them."""
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


def timed(run: Callable[[], object], repeats: int) -> float:
    """Least processor time of some runs, in ms."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        run()
        times.append(time.process_time() - start)
    return 1e3 * min(times)


def interval(low: F64, high: F64) -> str:
    return ", ".join(f"{least:+.4f} to {most:+.4f}" for least, most in zip(low, high, strict=True))


def degrees(found: F64, true: Rotation) -> float:
    return float(np.degrees((Rotation.from_matrix(found) * true.inv()).magnitude()))


def search(problems: int, repeats: int) -> None:
    """Errors over fixed problems, then times."""
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
    for name, (middle, high) in figures.items():
        pairs = zip(("rotation (deg)", "place", "scale"), middle, high, strict=True)
        texts = [f"{what} off by {median:.4f} in the median, {most:.4f} in the 95th percentile" for what, median, most in pairs]
        print(f"{name:>6}, {problems} problems of {PARTS} parts: {'; '.join(texts)}")
    both = np.stack([np.array(errors[name]) for name in ("kinmo", "NumPy")])
    drawn = np.random.default_rng(0).integers(0, both.shape[1], (DRAWS, both.shape[1]))
    apart = np.array([np.subtract(*np.percentile(both[:, rows], [50, 95], axis=1).swapaxes(0, 1)) for rows in drawn])
    low, high = np.percentile(apart, [2.5, 97.5], axis=0)
    print(f"kinmo above NumPy (rotation, place, scale): medians {interval(low[0], high[0])}; 95 % {interval(low[1], high[1])}")
    no_worse = bool((low <= 0.0).all())
    source, target, _ = clouds(0)
    own, theirs = timed(lambda: ours(source, target), repeats), timed(lambda: peer(source, target), max(1, repeats // 4))
    report("similarities of 3 parts x 1,024 pairs x 10,000 hypotheses, ms", own, theirs, SEARCH_GOAL, no_worse)


def joint(repeats: int) -> None:
    """The same sum of squares by either solver."""
    source, target, turns = clouds(1)
    source, target = source[:2], target[:2]
    direction, count = np.array([1.0, 0.0, 0.0]), POINTS
    starts = np.arange(3, dtype=np.int64) * POINTS
    start = np.stack([(turn * Rotation.from_rotvec([0.1, -0.1, 0.1])).as_matrix() for turn in turns[:2]])
    clouds_ = [(SCALE * (a - a.mean(0)), b - b.mean(0)) for a, b in zip(source, target, strict=True)]

    def residuals(vectors: F64) -> F64:
        found = Rotation.from_rotvec(vectors.reshape(2, 3))
        own = [(turn.apply(a) - b).ravel() for turn, (a, b) in zip(found, clouds_, strict=True)]
        tie = found[0].apply(direction) - found[1].apply(direction)
        return np.concatenate([*own, np.sqrt(count) * tie])

    def ours() -> F64:
        pairs, kinds = np.array([[0, 1]], np.uint32), np.zeros(1, np.uint8)
        return _core.tie_poses(
            source.reshape(-1, 3), target.reshape(-1, 3), starts, pairs, kinds, direction[None], start, np.full(2, SCALE),
            np.zeros((2, 3)), frames=np.array([0, 2]), threshold=1e3,
        )[0]  # fmt: skip

    def peer() -> F64:
        begin = Rotation.from_matrix(start).as_rotvec().ravel()
        return np.asarray(least_squares(residuals, begin, method="lm", ftol=1e-4).x)

    own_cost = np.sum(residuals(Rotation.from_matrix(ours()).as_rotvec().ravel()) ** 2)
    peer_cost = np.sum(residuals(peer()) ** 2)
    print(f"sum of squares: kinmo {own_cost:.9f}, SciPy {peer_cost:.9f}")
    own, theirs = timed(ours, repeats), timed(peer, repeats)
    report("two parts on a joint, 2 x 1,024 pairs, ms", own, theirs, JOINT_GOAL, bool(own_cost <= peer_cost * (1 + 1e-9)))


def report(claim: str, ours: float, peer: float, goal: float, no_worse: bool) -> None:
    ratio = peer / ours
    print(f"{claim}: kinmo {ours:.3f}, peer {peer:.1f}, {ratio:.0f} times")
    met = ratio >= goal and no_worse
    print(json.dumps({"claim": claim, "ours": ours, "peer": peer, "ratio": ratio, "goal": goal, "met": met}))


def main() -> None:
    """Both comparisons."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="few problems and repeats")
    quick = parser.parse_args().quick
    problems, repeats = QUICK if quick else (PROBLEMS, REPEATS)
    search(problems, repeats)
    joint(repeats)


if __name__ == "__main__":
    main()
