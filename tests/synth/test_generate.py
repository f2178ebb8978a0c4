"""Generation: it is deterministic, shapes are whole or absent, and files read back as they were built."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from kinmo.core.categories import canonical_category
from kinmo.core.errors import InputError
from kinmo.core.joint import JointKind
from kinmo.dataset.folder_preparation import ORACLE
from kinmo.dataset.splits import Split, split_of
from kinmo.io.discover import discover
from kinmo.io.readers import DSG_NET, PARTNET, PARTNET_MOBILITY, read_dsg_net, read_partnet, read_partnet_mobility
from kinmo.synth import generate
from kinmo.synth.draw import ParameterRange
from kinmo.synth.families import family_names
from kinmo.synth.generate import MAX_SHAPES, SPLIT_CYCLE, ShapeSpec, build_shape, shape_specs, write_shape, write_shapes
from kinmo.synth.synth_object import JointType
from kinmo.synth.writers import WRITERS

FAMILIES = ("safe", "microwave", "bottle", "window")


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def test_the_same_seed_gives_the_same_bytes_on_any_number_of_processes(tmp_path: Path) -> None:
    write_shapes(tmp_path / "one", shape_specs(3, families=FAMILIES[:2], seed=5))
    write_shapes(tmp_path / "two", shape_specs(3, families=FAMILIES[:2], seed=5), workers=2)
    write_shapes(tmp_path / "other", shape_specs(3, families=FAMILIES[:2], seed=6))
    one = contents(tmp_path / "one")
    assert one == contents(tmp_path / "two")
    assert not one.keys() & contents(tmp_path / "other").keys()


def test_a_shape_does_not_depend_on_what_else_is_written(tmp_path: Path) -> None:
    write_shapes(tmp_path / "many", shape_specs(3, families=FAMILIES, layouts=[PARTNET_MOBILITY]))
    write_shapes(tmp_path / "few", shape_specs(1, families=["window"], layouts=[PARTNET_MOBILITY]))
    many, few = contents(tmp_path / "many"), contents(tmp_path / "few")
    assert few.items() <= many.items()


def test_a_second_run_writes_only_what_is_missing(tmp_path: Path) -> None:
    assert write_shapes(tmp_path, shape_specs(2, families=FAMILIES[:1], layouts=[PARTNET])) == 2
    written: list[Path] = []
    again = write_shapes(tmp_path, shape_specs(3, families=FAMILIES[:1], layouts=[PARTNET]), on_written=written.append)
    assert again == 1 == len(written)
    assert written[0].name.endswith("00002")


def test_a_failed_write_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise OSError("disk full")

    monkeypatch.setitem(WRITERS, PARTNET, fail)
    with pytest.raises(OSError, match="disk full"):
        write_shapes(tmp_path, shape_specs(1, families=FAMILIES[:1], layouts=[PARTNET]))
    assert not list((tmp_path / "partnet").iterdir())


def test_ids_are_unique() -> None:
    ids = [spec.shape_id for seed in (0, 1) for spec in shape_specs(4, seed=seed)]
    assert len(ids) == len(set(ids))


@pytest.mark.parametrize("count", [0, -1, MAX_SHAPES + 1, 10**15])
def test_a_count_out_of_range_is_refused(tmp_path: Path, count: int) -> None:
    with pytest.raises(InputError, match="count"):
        write_shapes(tmp_path, shape_specs(count))


def test_a_layout_without_a_writer_is_refused() -> None:
    with pytest.raises(InputError, match="cannot write 'glb'"):
        next(shape_specs(1, layouts=["glb"]))


def test_labelled_and_unlabelled_layouts_have_different_ranges() -> None:
    ranges = {spec.layout: spec.parameter_range for spec in shape_specs(1, families=["safe"])}
    assert ranges[PARTNET_MOBILITY] is ParameterRange.LABELLED
    assert ranges[PARTNET] is ranges[DSG_NET] is ParameterRange.UNLABELLED


@pytest.mark.parametrize("name", family_names())
def test_mobility_reads_back_as_it_was_built(name: str, tmp_path: Path) -> None:
    for index in range(1):
        spec = ShapeSpec(name, index, 3, PARTNET_MOBILITY, ParameterRange.BOTH)
        obj, shape = build_shape(spec), read_partnet_mobility(write_shape(spec, tmp_path))
        leaves = list(obj.root.leaves())
        assert shape.category == obj.category
        assert [shape.parts[leaf].name for leaf in shape.leaves] == [leaf.name for leaf in leaves]
        assert len(shape.parts) == len(list(obj.root.walk()))
        np.testing.assert_allclose(shape.bounds, obj.bounds(), atol=2e-6)
        assert shape.mobility is not None
        bodies = {frozenset(body.leaves): body for body in shape.mobility.bodies}
        assert len(bodies) == len(obj.links)
        for link in obj.links:
            body = bodies[frozenset(shape.leaves[leaves.index(leaf)] for leaf in link.leaves())]
            assert (body.joint is None) == (link.motion is None)
            if body.joint is None or link.motion is None:
                continue
            unit = link.motion.direction / np.linalg.norm(link.motion.direction)
            assert abs(float(unit @ body.joint.direction)) > 1 - 1e-9
            assert (body.joint.kind is JointKind.REVOLUTE) == (link.motion.type is JointType.HINGE)
            assert (body.joint.kind is JointKind.SCREW) == link.motion.rotates
            if link.motion.has_position:
                across = np.cross(body.joint.pivot - link.motion.origin, unit)
                assert np.linalg.norm(across) < 1e-6
            if not link.motion.no_limit and link.motion.a != link.motion.b:
                assert body.joint.lower is not None and body.joint.upper is not None
                ends = [link.motion.a, link.motion.b]
                # The reader widens ranges of sliders that leave out the rest value.
                extent = float(np.ptp(ends if link.motion.is_hinge else [*ends, 0.0]))
                assert body.joint.upper - body.joint.lower == pytest.approx(
                    np.radians(extent) if link.motion.is_hinge else extent
                )


@pytest.mark.parametrize("name", family_names())
def test_unlabelled_layouts_can_be_read(name: str, tmp_path: Path) -> None:
    plain = ShapeSpec(name, 0, 3, PARTNET, ParameterRange.BOTH)
    obj, shape = build_shape(plain), read_partnet(write_shape(plain, tmp_path))
    assert shape.mobility is None
    np.testing.assert_allclose(shape.bounds, obj.bounds(), atol=2e-6)
    spec = ShapeSpec(name, 0, 3, DSG_NET, ParameterRange.BOTH)
    write_shape(spec, tmp_path)
    (tree,) = discover(tmp_path / "dsg_net")
    built, read = build_shape(spec), read_dsg_net(tree.path)
    assert read.id == spec.shape_id
    assert 2 <= len(read.leaves) <= len(list(built.root.leaves()))
    diagonal = np.linalg.norm(np.subtract(*built.bounds()))
    assert 0.5 < read.diagonal / diagonal < 1.3


def test_the_root_of_a_hierarchy_names_a_category_of_labelled_shapes() -> None:
    built = [build_shape(ShapeSpec(name, 0, 0, PARTNET, ParameterRange.BOTH)) for name in family_names()]
    assert {canonical_category(shape.root.name) for shape in built} <= {shape.category for shape in built}


def test_every_family_has_shapes_for_training_validation_and_test() -> None:
    for count, fewest in ((4, 1), (12, 1), (20, 2)):
        found: dict[str, list[Split]] = {}
        for spec in shape_specs(count, layouts=[PARTNET_MOBILITY]):
            found.setdefault(spec.family, []).append(split_of(spec.shape_id))
        for splits in found.values():
            assert min(splits.count(split) for split in Split) >= fewest
            assert splits == [SPLIT_CYCLE[index % len(SPLIT_CYCLE)] for index in range(count)]


def test_ids_depend_neither_on_the_count_nor_on_earlier_calls() -> None:
    many = [spec.shape_id for spec in shape_specs(30, families=["safe"], seed=3)]
    generate._balanced_numbers.cache_clear()
    alone = ShapeSpec("safe", 29, 3, PARTNET_MOBILITY, ParameterRange.LABELLED, balances_splits=True)
    assert alone.shape_id in many
    assert len(set(many)) == len(many)
    few = {spec.shape_id for spec in shape_specs(3, families=["safe"], seed=3)}
    assert few <= set(many)


def test_oracle_shapes_are_the_shapes_of_partnet_with_their_joints(tmp_path):
    write_shapes(tmp_path, shape_specs(2, families=FAMILIES[:2], layouts=[PARTNET], oracle=True))
    shown, bare = (sorted((tmp_path / name).iterdir()) for name in (ORACLE, "partnet"))
    assert [path.name for path in shown] == [path.name for path in bare]
    for one, other in zip(shown, bare, strict=True):
        annotated, plain = read_partnet_mobility(one), read_partnet(other)
        assert annotated.mobility is not None
        assert plain.mobility is None
        assert annotated.partnet_id == plain.partnet_id
        boxes = [np.sort([np.ptp(mesh.vertices, axis=0) for mesh in shape.meshes()], axis=0) for shape in (annotated, plain)]
        np.testing.assert_allclose(*boxes, atol=1e-6)
