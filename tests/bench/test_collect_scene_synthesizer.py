"""Objects of scene_synthesizer."""

from __future__ import annotations

import numpy as np
import pytest

import collect_scene_synthesizer
import mobility_from_urdf
import urdf_objects

NAMES = list(collect_scene_synthesizer.ASSETS)


@pytest.fixture
def generator():
    return pytest.importorskip("scene_synthesizer", reason="scene_synthesizer is not installed (bench/requirements.txt)")


@pytest.mark.parametrize("name", NAMES)
def test_a_seed_gives_one_set_of_parameters(name):
    draw = collect_scene_synthesizer.ASSETS[name].draw
    one, same, other = (str(draw(np.random.default_rng(seed), "folder")) for seed in (0, 0, 1))
    assert one == same != other


@pytest.mark.parametrize("name", NAMES)
def test_objects_move_against_a_base(name, generator, tmp_path):
    urdf_objects.write_urdf_object(tmp_path / f"{name}-0000", collect_scene_synthesizer.make_object(name, 0))
    shape, facts = mobility_from_urdf.read_urdf_object(tmp_path / f"{name}-0000")
    assert facts["licence"] == "Apache-2.0" and "folder" not in str(facts["parameters"])
    assert sum(body.parent is None for body in shape.mobility.bodies) == 1
    assert any(shape.mobility.movable()) and all(body.leaves for body in shape.mobility.bodies)


def test_equal_seeds_give_equal_objects(generator):
    one, other = (collect_scene_synthesizer.make_object("wall_cabinet", 5) for _ in range(2))
    for pieces, others in zip(one.links.values(), other.links.values(), strict=True):
        assert [piece.name for piece in pieces] == [piece.name for piece in others]
        assert all(np.array_equal(a.vertices, b.vertices) for a, b in zip(pieces, others, strict=True))
