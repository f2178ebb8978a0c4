"""Shapes of scenes: which meshes become parts, and what is guessed, whatever the format is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from gltf_files import PARTS, GltfBuilder, box, cabinet
from hypothesis import given, settings
from hypothesis import strategies as st

import kinmo
from kinmo.core.shape import Shape
from kinmo.io.readers.part_hierarchy import MAX_PARTS


def joined(*meshes: trimesh.Trimesh) -> trimesh.Trimesh:
    return trimesh.util.concatenate(meshes)


def volumes(shape: Shape) -> list[float]:
    return [trimesh.Trimesh(mesh.vertices, mesh.faces).volume for mesh in shape.meshes()]


def test_a_single_mesh_is_split_into_loose_pieces(tmp_path: Path) -> None:
    joined(*PARTS.values()).export(tmp_path / "a.glb")
    shape = kinmo.load(tmp_path / "a.glb")
    assert sorted(volumes(shape)) == pytest.approx(sorted(mesh.volume for mesh in PARTS.values()), abs=1e-6)
    assert [part.name for part in shape.parts[1:]] == ["", "", ""]
    assert shape.repairs == ("one mesh: split into 3 loose pieces",)


@pytest.mark.parametrize("ending", ["glb", "obj", "ply", "stl"])
def test_a_mesh_in_one_piece_is_an_error_that_names_the_remedy(ending: str, tmp_path: Path) -> None:
    trimesh.creation.icosphere().export(tmp_path / f"a.{ending}")
    with pytest.raises(kinmo.InputError, match=r"one closed mesh, so no parts .*: separate .* --labels faces\.npy"):
        kinmo.load(tmp_path / f"a.{ending}")


def blocks_in_a_row(gap: float) -> list[trimesh.Trimesh]:
    """Blocks that are as far apart, and a far one."""
    boxes = [((i * (1.0 + gap), 0.0, 0.0), (i * (1.0 + gap) + 1.0, 1.0, 1.0 + 0.5 * (i % 2))) for i in range(3)]
    return [trimesh.creation.box(bounds=bounds) for bounds in [*boxes, ((9.0, 0.0, 0.0), (10.0, 1.0, 1.0))]]


def write_nodes(path: Path, nodes: dict[str, trimesh.Trimesh]) -> Path:
    scene = trimesh.Scene()
    for name, mesh in nodes.items():
        scene.add_geometry(mesh, node_name=name, geom_name=name)
    scene.export(path)
    return path


@pytest.mark.parametrize("as_one_mesh", [True, False])
def test_loose_pieces_without_names_are_divided_at_creases(as_one_mesh: bool, tmp_path: Path) -> None:
    *row, far = blocks_in_a_row(0.0)
    nodes = {"whole": joined(*row, far)} if as_one_mesh else {"part_0": joined(*row), "part_1": far}
    shape = kinmo.load(write_nodes(tmp_path / "a.glb", nodes))
    assert sorted(volumes(shape)) == pytest.approx([1.0, 1.0, 1.0, 1.5])
    assert sorted(len(part.children) for part in shape.parts if part.children) == [2, 3]
    assert shape.repairs[-1] == "2 loose pieces: divided at creases into 4 patches"


@pytest.mark.parametrize("names", [("frame", "drawer"), ("part_0", "part_1")])
def test_parts_with_names_or_several_loose_pieces_are_not_divided(names: tuple[str, str], tmp_path: Path) -> None:
    *row, far = blocks_in_a_row(0.0)
    apart = trimesh.creation.box(bounds=((9.0, 3.0, 0.0), (10.0, 4.0, 1.0)))
    others = far if names[0] == "frame" else joined(far, apart)
    shape = kinmo.load(write_nodes(tmp_path / "a.glb", dict(zip(names, (joined(*row), others), strict=True))))
    assert [part.name for part in shape.parts[1:]] == list(names) and not shape.repairs


def test_one_welded_mesh_is_divided_at_creases(tmp_path: Path) -> None:
    shape = kinmo.load(write_nodes(tmp_path / "a.glb", {"whole": joined(*blocks_in_a_row(0.0)[:3])}))
    assert sorted(volumes(shape)) == pytest.approx([1.0, 1.0, 1.5])
    assert shape.repairs == ("one mesh: split into 1 loose piece", "1 loose piece: divided at creases into 3 patches")


@pytest.mark.parametrize("ending", ["glb", "obj", "ply", "stl"])
def test_labels_are_the_parts(ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"a.{ending}"
    trimesh.creation.icosphere(subdivisions=2).export(path)
    faces = trimesh.load_mesh(path, process=False).triangles
    labels = np.where(faces.mean(axis=1)[:, 2] > 0.3, 7, -1)
    np.save(tmp_path / "faces.npy", labels)
    shape = kinmo.load(path, labels=tmp_path / "faces.npy")
    wanted = sorted(faces[labels == label].mean(axis=(0, 1))[2] for label in (7, -1))
    found = sorted(mesh.triangles.mean(axis=(0, 1))[2] for mesh in shape.meshes())
    assert found == pytest.approx(wanted, abs=1e-5)
    assert [part.name for part in shape.parts] == ["", "", ""]


def test_labels_count_over_all_nodes_in_the_order_of_the_file(tmp_path: Path) -> None:
    path = cabinet().write_glb(tmp_path / "a.glb")
    np.save(tmp_path / "faces.npy", np.repeat([0, 1, 0], 12))
    shape = kinmo.load(path, labels=tmp_path / "faces.npy")
    wanted = [PARTS["body"].volume + PARTS["knob"].volume, PARTS["door"].volume]
    assert volumes(shape) == pytest.approx(wanted, abs=1e-6)


@pytest.mark.parametrize(
    ("labels", "problem"),
    [
        (np.zeros(35, int), r"expected 36 integers, one per triangle of a\.glb in the order of the file, got \[35\]"),
        (np.zeros(36), "expected 36 integers"),
        (np.zeros(36, int), "expected at least two labels"),
        (np.array([{}] * 36), "expected an .npy file with one integer per triangle"),
    ],
)
def test_labels_that_do_not_fit_are_an_error(labels: np.ndarray, problem: str, tmp_path: Path) -> None:
    path = cabinet().write_glb(tmp_path / "a.glb")
    np.save(tmp_path / "faces.npy", labels, allow_pickle=True)
    with pytest.raises(kinmo.InputError, match=rf"faces\.npy: {problem}"):
        kinmo.load(path, labels=tmp_path / "faces.npy")


@pytest.mark.parametrize("as_nodes", [False, True])
def test_the_smallest_of_too_many_parts_join_the_nearest_larger_ones(as_nodes: bool, tmp_path: Path) -> None:
    large = [box((1.0, 1.0, 1.0), (2.0 * i, 0.0, 0.0)) for i in range(MAX_PARTS)]
    screws = [box((0.1, 0.1, 0.1), (2.0 * i, 0.0, 0.6)) for i in range(0, 400, 20)]
    scene = trimesh.Scene(large + screws) if as_nodes else joined(*large, *screws)
    scene.export(tmp_path / "a.glb")
    shape = kinmo.load(tmp_path / "a.glb")
    assert len(shape.leaves) == MAX_PARTS
    assert "1020 parts: the 20 smallest ones merged into the nearest larger ones" in shape.repairs
    with_screw = [mesh.vertices[:, 0].mean() / 2.0 for mesh in shape.meshes() if len(mesh.faces) == 24]
    assert sorted(with_screw) == pytest.approx(list(range(0, 400, 20)), abs=1e-6)


@pytest.mark.parametrize("height", [0.0, 0.02])
def test_a_floor_is_dropped(height: float, tmp_path: Path) -> None:
    made = cabinet()
    floor = trimesh.Trimesh([[-8, -1, -8], [8, -1, -8], [8, -1, 8], [-8, -1, 8]], [[0, 2, 1], [0, 3, 2]])
    if height:
        floor = box((16.0, height, 16.0), (0.0, -1.0 - height / 2, 0.0))
    top = made.document["scenes"][0]["nodes"][0]
    shape = kinmo.load(made.scene(made.node("Plane", mesh=made.mesh(floor)), top).write_glb(tmp_path / "a.glb"))
    assert shape.parts[0].name == "StorageFurniture"
    assert sorted(shape.parts[leaf].name for leaf in shape.leaves) == ["body", "door", "knob"]
    assert len(shape.repairs) == 1 and "(Plane) is a floor: dropped" in shape.repairs[0]


SIZES = (2.0, 0.02, 1.0), (16.0, 0.02, 16.0), (16.0, 3.0, 16.0)


@pytest.mark.parametrize(("size", "at"), list(zip(SIZES, [(0.0, -1.0, 0.0), (0.0, 0.0, 0.0), (0.0, -3.0, 0.0)], strict=True)))
def test_a_base_plate_a_shelf_and_a_block_are_no_floors(
    size: tuple[float, float, float], at: tuple[float, float, float], tmp_path: Path
) -> None:
    made = cabinet()
    top = made.document["scenes"][0]["nodes"][0]
    shape = kinmo.load(made.scene(made.node("plate", mesh=made.mesh(box(size, at))), top).write_glb(tmp_path / "a.glb"))
    assert "plate" in {part.name for part in shape.parts}


@settings(max_examples=20, deadline=None)
@given(st.permutations(range(5)))
def test_neither_node_order_nor_file_name_matters(tmp_path_factory: pytest.TempPathFactory, order: list[int]) -> None:
    boxes = [box((1.0 + 0.1 * i, 1.0, 0.5), (2.0 * i, 0.1 * i, 0.0)) for i in range(4)] + [
        box((1.0, 1.0, 0.5), (-2.0, 0.0, 0.0))
    ]

    def load(name: str, order: list[int]) -> Shape:
        made = GltfBuilder()
        nodes = [made.node(f"part {i}", mesh=made.mesh(boxes[i])) for i in order]
        return kinmo.load(made.scene(*nodes).write_glb(tmp_path_factory.mktemp("a") / name))

    one, other = load("cabinet.glb", list(range(5))), load("Refrigerator.glb", order)
    assert [part.name for part in one.parts] == [part.name for part in other.parts]
    for mesh, same in zip(one.meshes(), other.meshes(), strict=True):
        np.testing.assert_array_equal(mesh.triangles, same.triangles)
    assert one.category == other.category == ""


def test_groups_without_a_name_around_one_node_change_nothing(tmp_path: Path) -> None:
    def load(depth: int) -> Shape:
        made = GltfBuilder()
        nodes = [made.node(name, mesh=made.mesh(mesh)) for name, mesh in PARTS.items()]
        for _ in range(depth):
            nodes = [made.node("", children=[node]) if number else node for number, node in enumerate(nodes)]
        return kinmo.load(made.scene(*nodes).write_glb(tmp_path / f"{depth}.glb"))

    flat, nested = load(0), load(2)
    assert [(part.name, part.parent, part.children) for part in nested.parts] == [
        (part.name, part.parent, part.children) for part in flat.parts
    ]


@pytest.mark.parametrize("name", ["柜门", "ящик", "درج", "Tür №1", "दरवाज़ा"])
def test_names_of_any_script_are_kept(name: str, tmp_path: Path) -> None:
    made = cabinet()
    for node in made.document["nodes"]:
        node["name"] = name
    shape = kinmo.load(made.write_glb(tmp_path / "a.glb"))
    assert {part.name for part in shape.parts} == {name}
    objects = "".join(f"o {name} {i}\nv {i} 0 0\nv {i} 1 0\nv {i} 0 1\nf -3 -2 -1\n" for i in range(2))
    (tmp_path / "a.obj").write_text(objects, encoding="utf-8")
    assert {part.name for part in kinmo.load(tmp_path / "a.obj").parts} == {"", f"{name} 0", f"{name} 1"}


@pytest.mark.parametrize(
    ("ending", "scale", "unit"),
    [
        ("glb", 1e3, 1.0),
        ("obj", 1.0, 1.0),
        ("obj", 50.0, 0.01),
        ("obj", 1e3, 0.001),
        ("stl", 1.0, 1.0),
        ("stl", 50.0, 0.001),
    ],
)
def test_the_unit_is_guessed_by_format_and_size(ending: str, scale: float, unit: float, tmp_path: Path) -> None:
    joined(*PARTS.values()).apply_scale(scale).export(tmp_path / f"a.{ending}")
    assert kinmo.load(tmp_path / f"a.{ending}").metres_per_unit == unit
    assert kinmo.load(tmp_path / f"a.{ending}", metres_per_unit=0.5).metres_per_unit == 0.5


@pytest.mark.parametrize(
    ("ending", "up", "front"), [("glb", "y", "z"), ("obj", "y", "z"), ("stl", "z", "-y"), ("ply", "z", "-y")]
)
def test_up_and_front_follow_the_format_unless_they_are_stated(ending: str, up: str, front: str, tmp_path: Path) -> None:
    vectors = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1), "-x": (-1, 0, 0), "-y": (0, -1, 0)}
    path = tmp_path / f"a.{ending}"
    joined(*PARTS.values()).export(path)
    shape = kinmo.load(path)
    assert (shape.up, shape.front) == (vectors[up], vectors[front])
    assert shape.guesses["up"] == f"up +{up} ({'glTF' if ending == 'glb' else ending.upper()})"
    stated = kinmo.load(path, up="x", front="-y", category="door_set")
    assert (stated.up, stated.front, stated.category) == (vectors["x"], vectors["-y"], "Door")
    assert stated.guesses.keys() == {"metres_per_unit"}
    assert kinmo.load(path, up="-x").front is None
    with pytest.raises(kinmo.InputError, match="--front: z is not perpendicular to the up direction"):
        kinmo.load(path, up="z", front="z")
    with pytest.raises(kinmo.InputError, match="up: expected one of x, y, z"):
        kinmo.load(path, up="w")  # type: ignore[arg-type]


def test_an_obj_file_that_stands_on_the_ground_of_a_cad_tool_has_z_up(tmp_path: Path) -> None:
    joined(box((1.0, 0.5, 2.0), (0.0, 0.0, 1.0)), box((0.1, 0.1, 0.1), (0.0, -0.2, 2.1))).export(tmp_path / "a.obj")
    shape = kinmo.load(tmp_path / "a.obj")
    assert (shape.up, shape.front) == ((0.0, 0.0, 1.0), (0.0, -1.0, 0.0))
