"""Readers of public datasets. Each returns a `kinmo.shape.Shape` or raises `kinmo.errors.InputError`."""

from kinmo.formats.discover import Found, Layout, discover
from kinmo.formats.dsg_net import read_dsg_net
from kinmo.formats.glb import read_glb
from kinmo.formats.partnet import read_partnet
from kinmo.formats.partnet_mobility import read_partnet_mobility
from kinmo.shape import Shape

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
