"""One writer per dataset layout. Each writes one object into an empty folder."""

from collections.abc import Callable
from pathlib import Path

from kinmo.io.readers import Layout
from kinmo.synth.draw import Draw
from kinmo.synth.synth_object import SynthObject
from kinmo.synth.writers import dsg_net_writer, partnet_mobility_writer, partnet_writer

Writer = Callable[[SynthObject, str, Path, Draw], None]
"""Function that writes an object, with its id, into a folder. It may change the object."""
WRITERS: dict[Layout, Writer] = {
    Layout.PARTNET_MOBILITY: partnet_mobility_writer.write,
    Layout.PARTNET: partnet_writer.write,
    Layout.DSG_NET: dsg_net_writer.write,
}
"""Writer of each layout that procedural shapes can be written in."""
