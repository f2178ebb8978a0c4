"""The reader of DAE files: names of nodes that are shown by instances."""

from __future__ import annotations

from pathlib import Path

import pytest

from kinmo.io.readers.dae_reader import read_dae_scene

pytest.importorskip("collada")

DOCUMENT = """<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_nodes>{library}</library_nodes>
<library_visual_scenes><visual_scene id="s">{scene}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"""
DOOR = '<node id="c1" name="door"><instance_geometry url="#g"/>{}</node>'
KNOB = '<node id="c2" name="knob"><instance_geometry url="#g"/></node>'
SHOWS_KNOB = '<instance_node url="#c2"/>'


def names(path: Path, library: str, scene: str) -> list[str]:
    """Names of the nodes of a scene in the order of the file, without the root."""
    path.write_text(DOCUMENT.format(library=library, scene=scene))
    return [node.name for node in read_dae_scene(path).nodes[1:]]


def test_instances_have_the_name_of_their_node_as_in_files_of_sketchup(tmp_path: Path) -> None:
    instances = (f'<node name="instance_{i}"><instance_node url="#c{i + 1}"/></node>' for i in range(2))
    found = names(tmp_path / "a.dae", DOOR.format("") + KNOB, "".join(instances))
    assert found == ["instance_0", "door", "instance_1", "knob"]


def test_instances_in_instances_have_names(tmp_path: Path) -> None:
    scene = '<node name="instance_0"><instance_node url="#c1"/></node>'
    assert names(tmp_path / "a.dae", DOOR.format(SHOWS_KNOB) + KNOB, scene) == ["instance_0", "door", "knob"]


def test_the_name_of_an_instance_itself_comes_first(tmp_path: Path) -> None:
    scene = f'<node name="top"><instance_node name="left knob" url="#c2"/>{SHOWS_KNOB}</node>'
    assert names(tmp_path / "a.dae", KNOB, scene) == ["top", "left knob", "knob"]
