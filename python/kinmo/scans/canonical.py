"""The state, and the base, that all objects of a category are compared in, whatever their files show."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinmo.mobility import Mobility
from kinmo.scans.closing import closed
from kinmo.scans.likely_closed import likely_closed
from kinmo.scans.visible_base import laid_straight, with_first_base, with_visible_base
from kinmo.shape import Mesh

Parts = tuple[Mobility, tuple[Mesh, ...]]


def canonical(mobility: Mobility, meshes: Sequence[Mesh], smallest: float, to_z_up: NDArray[np.float64], closes: bool) -> Parts:
    """The object with a base that can be seen (`visible_base`), its joints at their closed ends (`closing`) if it `closes`.

    `meshes` are those of the bodies; `smallest` and `to_z_up` are as in `with_visible_base`.
    """
    parts: Parts = closed(mobility, meshes) if closes else (mobility, tuple(meshes))
    mobility, meshes, _ = with_visible_base(*parts, smallest, to_z_up)
    # once more: of parts that open the same way the one that is a base now does not close
    return closed(mobility, meshes) if closes else (mobility, tuple(meshes))


def likely_canonical(
    mobility: Mobility, meshes: Sequence[Mesh], smallest: float, to_z_up: NDArray[np.float64], widest: float
) -> Parts:
    """The same of an object whose limits are guesses: closed as is likely (`likely_closed`), hinges opening to `widest`.

    What hangs by something that cannot be seen is thought to fold, and to lie straight then.
    """
    mobility, meshes, hung_by = with_visible_base(mobility, meshes, smallest, to_z_up)
    parts = closed(likely_closed(mobility, meshes, widest, folds=hung_by is not None), meshes)
    return parts if hung_by is None else with_first_base(*laid_straight(*parts, hung_by), smallest, to_z_up)
