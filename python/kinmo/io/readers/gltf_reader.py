"""glTF 2.0, as GLB or as .gltf with its buffers: the nodes of the scene are the parts, with y up and the front at +z."""

from __future__ import annotations

from pathlib import Path

from kinmo.core.shape import Shape
from kinmo.io.readers.gltf_file import GltfFile, other_files
from kinmo.io.readers.gltf_scene import GltfScene
from kinmo.io.readers.reader import Reader
from kinmo.io.readers.scene import Scene
from kinmo.io.readers.scene_shape import id_by_ending, shape_of_scene
from kinmo.io.readers.stated_facts import NO_FACTS, StatedFacts

GLB = "glb"
_ENDINGS = (".glb", ".gltf")


def read_glb(path: Path, facts: StatedFacts = NO_FACTS) -> Shape:
    """Read a glTF file. The nodes of its default scene become parts (see `shape_of_scene`)."""
    return shape_of_scene(read_glb_scene(Path(path)), facts)


def read_glb_scene(path: Path) -> Scene:
    """The default scene of a glTF file."""
    scene = GltfScene(GltfFile(path))
    return Scene(path, GLB, scene.nodes, "y", "glTF", 1.0, unread=scene.unread)


READER = Reader(
    GLB,
    read_glb,
    lambda path: (path.absolute().parent, [path, *other_files(path)]),
    id_of_file=id_by_ending(_ENDINGS),
    endings=_ENDINGS,
    read_stated=read_glb,
)
