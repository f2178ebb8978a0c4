"""Single mechanisms, independent of any object: a flap, a drawer, a caster, an arm of several links.

Each builder takes a `Draw` and gives a `Mechanism` in a cell of about [-0.5, 0.5]^2 on the plane z = 0, its outside towards +z.
`mount` puts a mechanism on an object.

The modules `hollow`, `housing`, `pedestal`, `slab` and `slender` build whole objects that carry mechanisms. Their functions
take a `Draw` and `crowded`, which makes additional small mechanisms more likely.
"""

from kinmo.synth.mechanisms.covers import COVERING
from kinmo.synth.mechanisms.linked import LINKED
from kinmo.synth.mechanisms.mechanism_model import Mechanism, MechanismBuilder, MovingPart
from kinmo.synth.mechanisms.sliding import SLIDING, STRETCHABLE_SLIDING
from kinmo.synth.mechanisms.turning import STRETCHABLE_TURNING, TURNING

MECHANISMS: tuple[MechanismBuilder, ...] = (*TURNING, *SLIDING, *LINKED, *COVERING)
"""All mechanisms. Frequent ones are listed more than once."""
STRETCHABLE: tuple[MechanismBuilder, ...] = (*STRETCHABLE_TURNING, *STRETCHABLE_SLIDING)
"""Mechanisms that may be stretched to fill one side of an object."""

__all__ = ["MECHANISMS", "STRETCHABLE", "Mechanism", "MechanismBuilder", "MovingPart"]
