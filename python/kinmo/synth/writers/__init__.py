"""Writers of procedural shapes, one per dataset layout."""

from collections.abc import Callable
from pathlib import Path

from kinmo.io.readers import DSG_NET, PARTNET, PARTNET_MOBILITY
from kinmo.synth.draw import Draw
from kinmo.synth.synth_object import SynthObject
from kinmo.synth.writers import dsg_net_layout, partnet_layout, partnet_mobility_layout

Writer = Callable[[SynthObject, str, Path, Draw], None]
"""Function that writes an object.

Args:
    obj: The object, normalised. The writer may change it.
    shape_id: Id of the shape.
    folder: An empty folder to write into.
    draw: Random values of the files.
"""
WRITERS: dict[str, Writer] = {
    PARTNET_MOBILITY: partnet_mobility_layout.write,
    PARTNET: partnet_layout.write,
    DSG_NET: dsg_net_layout.write,
}
"""Writer of each layout that procedural shapes can be written in."""
