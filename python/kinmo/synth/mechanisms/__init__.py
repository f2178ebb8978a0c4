"""Single mechanisms, whatever they belong to: a flap, a drawer, a caster, an arm of several links.

Each builder takes a `Draw` and gives a `Mechanism` that stands on the plane z = 0 in a cell of about [-0.5, 0.5]^2, its outside
towards +z.
"""

from kinmo.synth.mechanisms.linked import LINKED
from kinmo.synth.mechanisms.model import Builder, Mechanism, Moving
from kinmo.synth.mechanisms.sliding import FITTED_SLIDING, SLIDING
from kinmo.synth.mechanisms.turning import FITTED_TURNING, TURNING

MECHANISMS: tuple[Builder, ...] = (*TURNING, *SLIDING, *LINKED)
"""All of them, the commoner ones more than once."""
FITTED: tuple[Builder, ...] = (*FITTED_TURNING, *FITTED_SLIDING)
"""Those that may be stretched to fill a side of what they are part of."""

__all__ = ["FITTED", "MECHANISMS", "Builder", "Mechanism", "Moving"]
