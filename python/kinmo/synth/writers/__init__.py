"""Writers of procedural shapes, one per dataset layout."""

from collections.abc import Callable
from pathlib import Path

from kinmo.io.readers import DSG_NET, PARTNET, PARTNET_MOBILITY
from kinmo.synth.draw import Draw
from kinmo.synth.synth_object import SynthObject
from kinmo.synth.writers import dsg_net_writer, partnet_mobility_writer, partnet_writer

Writer = Callable[[SynthObject, str, Path, Draw], None]
"""Function that writes an object.

Args:
    obj: The object, normalised. The writer may change it.
    shape_id: Id of the shape.
    folder: An empty folder to write into.
    draw: Random values of the files.
"""
WRITERS: dict[str, Writer] = {
    PARTNET_MOBILITY: partnet_mobility_writer.write,
    PARTNET: partnet_writer.write,
    DSG_NET: dsg_net_writer.write,
}
"""Writer of each layout that procedural shapes can be written in."""
