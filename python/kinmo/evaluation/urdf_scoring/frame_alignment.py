"""Alignment of a predicted object with the truth: one of 24 rotations, a scale and a shift."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray

from kinmo.core.frames import Y_UP_TO_Z_UP
from kinmo.evaluation.urdf_scoring.sampled_surface import NEIGHBOURS, Points, Surface

PREFERRED = (Y_UP_TO_Z_UP.T, np.eye(3), np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]))
"""Rotations to prefer where several fit equally well: PartNet-Mobility's z-up, the file's own y-up, plain z-up."""
COARSE, FINE = 300, 2000  # samples a side in the first and the second round of the search
SHORTLIST = 9  # candidates that pass the first round
MAX_COARSE_EXCESS = 0.02
"""Candidates whose coarse residual exceeds the best by more than this (diagonals) are dropped."""
REFINED, REFINE_ABOVE, REFINE_STEPS = 3, 1e-3, 12
"""The best three candidates are refined in 12 steps, if their residual is above 0.1 % of the diagonal."""
TRIM = 0.8  # share of the nearer samples that refinement fits
TIE_FACTOR, TIE_OFFSET = 1.1, 1e-4
"""Candidates with a residual of at most 1.1 times the best plus 0.0001 diagonals fit equally well."""


@dataclass(frozen=True, eq=False)
class Similarity:
    """A similarity: true = scale * rotation @ predicted + shift.

    `residual` is the mean distance of the aligned surfaces, in true diagonals.
    """

    rotation: NDArray[np.float64]
    scale: float
    shift: Points
    residual: float = np.inf

    def apply(self, points: Points) -> Points:
        """Predicted points [..., 3] in the frame of the truth."""
        return np.asarray(self.scale * points @ self.rotation.T + self.shift)

    def undo(self, points: Points) -> Points:
        """True points [..., 3] in the frame of the prediction."""
        return np.asarray((points - self.shift) @ self.rotation / self.scale)


def axis_rotations() -> list[NDArray[np.float64]]:
    """The 24 rotations [3, 3] that map coordinate axes to coordinate axes."""
    matrices = [np.diag(signs)[list(order)] for order in permutations(range(3)) for signs in product((1.0, -1.0), repeat=3)]
    return [matrix for matrix in matrices if np.linalg.det(matrix) > 0]


def align_surfaces(kept: Surface, everything: Surface, predicted: Surface) -> Similarity:
    """Find the similarity that aligns a prediction with the truth.

    The prediction may contain the truth's junk or not. It is searched for in `everything`, the surface with junk, and must
    cover `kept`, the surface without. The residual is the mean of the two directed mean distances over the diagonal of `kept`.
    """

    def measured(guess: Similarity, count: int, neighbours: int = NEIGHBOURS) -> Similarity:
        """The guess with its residual over `count` samples a side."""
        forward = predicted.nearest(guess.undo(kept.points[:count]), neighbours)[0].mean() * guess.scale
        back = everything.nearest(guess.apply(predicted.points[:count]), neighbours)[0].mean()
        return replace(guess, residual=float(0.5 * (forward + back) / kept.diagonal))

    def by_residual(guesses: list[Similarity]) -> list[Similarity]:
        return sorted(guesses, key=lambda guess: guess.residual)

    guesses = by_residual([measured(guess, COARSE, 1) for guess in _guesses(kept, everything, predicted)])[:SHORTLIST]
    guesses = [guess for guess in guesses if guess.residual <= guesses[0].residual + MAX_COARSE_EXCESS]
    guesses = by_residual([measured(guess, FINE) for guess in guesses])
    improvable = [guess for guess in guesses[:REFINED] if guess.residual > REFINE_ABOVE]
    guesses += [measured(_refined(guess, everything, predicted.points[:FINE]), FINE) for guess in improvable]
    limit = TIE_FACTOR * min(guess.residual for guess in guesses) + TIE_OFFSET
    return min((g for g in guesses if g.residual <= limit), key=lambda g: (_preference(g.rotation), g.residual))


def _guesses(kept: Surface, everything: Surface, predicted: Surface) -> list[Similarity]:
    """Every rotation with unchanged lengths, and with the boxes aligned, with and without junk."""
    targets = [kept] if everything is kept else [kept, everything]
    guesses = []
    for rotation in axis_rotations():
        guesses.append(Similarity(rotation, 1.0, np.zeros(3)))
        for target in targets:
            scale = target.diagonal / max(predicted.diagonal, 1e-300)
            guesses.append(Similarity(rotation, scale, target.middle - scale * rotation @ predicted.middle))
    return guesses


def _refined(guess: Similarity, everything: Surface, probes: Points) -> Similarity:
    """The guess with the scale and shift that fit the nearer 80 % of the probes best, by trimmed iterative closest points."""
    turned = probes @ guess.rotation.T
    scale, shift = guess.scale, guess.shift
    for _ in range(REFINE_STEPS):
        distances, feet = everything.nearest(scale * turned + shift)
        used = distances <= np.quantile(distances, TRIM)
        source, target = turned[used], feet[used]
        spread, goal = source - source.mean(axis=0), target - target.mean(axis=0)
        best = float(np.sum(spread * goal) / max(np.sum(spread * spread), 1e-300))
        scale = max(best, 0.01 * scale)
        shift = target.mean(axis=0) - scale * source.mean(axis=0)
    return Similarity(guess.rotation, scale, shift)


def _preference(rotation: NDArray[np.float64]) -> int:
    """Rank of a rotation among the preferred ones; the others come last."""
    return next((rank for rank, preferred in enumerate(PREFERRED) if np.array_equal(rotation, preferred)), len(PREFERRED))
