"""The reader of PartNet."""

from __future__ import annotations

import pytest
from datasets import RESULT, write_partnet

from kinmo.core.errors import InputError
from kinmo.io.readers import read_partnet


def test_a_shape_without_mobility_has_the_same_parts(tmp_path):
    shape = read_partnet(write_partnet(tmp_path / "4711"))
    assert [part.id for part in shape.parts] == list(range(8))
    assert shape.mobility is None
    assert (shape.layout, shape.partnet_id) == ("partnet", "4711")


def test_the_merged_hierarchy_is_read_if_there_is_no_other(tmp_path):
    merged = [RESULT[0] | {"ori_id": 0, "objs": ["original-1", "original-2"]}]
    shape = read_partnet(write_partnet(tmp_path / "4711", merged, file="result_after_merging.json"))
    assert [part.id for part in shape.parts] == list(range(8)), "a node with children lists the meshes of its leaves"


def test_a_folder_without_hierarchy_or_meshes_is_an_error(tmp_path):
    folder = write_partnet(tmp_path / "4711")
    (folder / "result.json").rename(folder / "other.json")
    with pytest.raises(InputError, match=r"result\.json"):
        read_partnet(folder)
    (folder / "other.json").rename(folder / "result.json")
    (folder / "objs").rename(folder / "meshes")
    with pytest.raises(InputError, match="textured_objs or objs"):
        read_partnet(folder)
