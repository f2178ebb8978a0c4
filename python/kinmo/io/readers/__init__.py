"""Readers of public datasets. Each returns a `kinmo.core.shape.Shape` or raises `kinmo.core.errors.InputError`."""

from kinmo.core.shape import Shape
from kinmo.io.readers.discover import Found, Layout, discover
from kinmo.io.readers.dsg_net_reader import read_dsg_net
from kinmo.io.readers.glb_reader import read_glb
from kinmo.io.readers.partnet_mobility_reader import read_partnet_mobility
from kinmo.io.readers.partnet_reader import read_partnet

__all__ = ["Found", "Layout", "discover", "read_dsg_net", "read_found", "read_glb", "read_partnet", "read_partnet_mobility"]

_READERS = {
    Layout.PARTNET_MOBILITY: read_partnet_mobility,
    Layout.PARTNET: read_partnet,
    Layout.DSG_NET: read_dsg_net,
    Layout.GLB: read_glb,
}


def read_found(found: Found) -> Shape:
    """Reads what `discover` found."""
    return _READERS[found.layout](found.path)
