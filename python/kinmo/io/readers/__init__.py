"""Readers of shapes, one input format per module.

To add a format, write a module `<format>_reader.py` that defines `READER` (see `kinmo.io.readers.reader`) and list it here.
"""

from kinmo.io.readers import (
    dae_reader,
    dsg_net_reader,
    gltf_reader,
    mesh_folder_reader,
    mjcf_reader,
    obj_scene_reader,
    partnet_mobility_reader,
    partnet_reader,
    ply_reader,
    stl_reader,
    threemf_reader,
    urdf_reader,
    usd_reader,
)
from kinmo.io.readers.dsg_net_reader import DSG_NET, read_dsg_net
from kinmo.io.readers.gltf_reader import GLB, read_glb
from kinmo.io.readers.partnet_mobility_reader import PARTNET_MOBILITY, read_partnet_mobility
from kinmo.io.readers.partnet_reader import PARTNET, read_partnet
from kinmo.io.readers.reader import Reader

__all__ = [
    "DSG_NET", "GLB", "PARTNET", "PARTNET_MOBILITY", "READERS",
    "Reader", "read_dsg_net", "read_glb", "read_partnet", "read_partnet_mobility",
]  # fmt: skip

_MODULES = (
    partnet_mobility_reader, partnet_reader, dsg_net_reader, gltf_reader, usd_reader, dae_reader, threemf_reader, urdf_reader,
    mjcf_reader, obj_scene_reader, ply_reader, stl_reader, mesh_folder_reader,
)  # fmt: skip
"""Reader modules. The first one that recognises a file or folder reads it."""

READERS: dict[str, Reader] = {module.READER.layout: module.READER for module in _MODULES}
"""All readers by the name of their format."""
