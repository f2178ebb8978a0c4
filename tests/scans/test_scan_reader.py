"""Scans of users, from all kinds of files."""

from __future__ import annotations

import io
from pathlib import Path
from zipfile import ZIP_LZMA, ZipFile

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from kinmo.core.errors import InputError
from kinmo.scans.camera import Camera
from kinmo.scans.scan_reader import Intrinsics, count_places, read_scan

POINTS = np.random.default_rng(0).uniform(0.5, 1.5, (100, 3))
CAMERA = Intrinsics(100.0, 110.0, 15.5, 11.5)


def test_points_come_back_from_arrays_and_from_ply(tmp_path):
    np.save(tmp_path / "a.npy", POINTS)
    np.savez(tmp_path / "b.npz", points=POINTS.astype(np.float32))
    trimesh.PointCloud(POINTS).export(tmp_path / "c.ply")
    for name in ("a.npy", "b.npz", "c.ply"):
        np.testing.assert_allclose(read_scan(tmp_path / name).points, POINTS, atol=1e-6)


def test_a_depth_image_gives_the_points_that_its_camera_sees(tmp_path):
    camera = Camera(32, 24, np.array([100.0, 110.0]), np.array([16.0, 12.0]), 0.1, 10.0)
    depth = np.random.default_rng(1).uniform(1.0, 2.0, (24, 32))
    depth[3, 4], depth[5, 6] = 0.0, np.nan
    millimetres = np.round(np.nan_to_num(depth) * 1000.0).astype(np.uint16)
    millimetres[5, 6] = 65535  # as cameras have it that say so of what is too far for them
    seen = np.flatnonzero(np.nan_to_num(depth.ravel()) > 0.0)
    expected = camera.points(depth.ravel()[seen], seen)
    matrix = [[100.0, 0.0, 15.5], [0.0, 110.0, 11.5], [0.0, 0.0, 1.0]]
    np.savez(tmp_path / "with.npz", depth=depth, intrinsics=matrix)
    np.save(tmp_path / "bare.npy", depth)
    Image.fromarray(millimetres).save(tmp_path / "image.png")
    np.testing.assert_allclose(read_scan(tmp_path / "with.npz").points, expected)
    np.testing.assert_array_equal(read_scan(tmp_path / "with.npz").places, seen)
    np.testing.assert_allclose(read_scan(tmp_path / "bare.npy", CAMERA).points, expected)
    np.testing.assert_allclose(read_scan(tmp_path / "image.png", CAMERA, 1000.0).points, expected, atol=2e-3)


@pytest.mark.parametrize("order", ["<u2", ">u2"])
@pytest.mark.parametrize("ending", ["npy", "npz", "tif"])
def test_what_is_too_far_for_16_bits_is_not_seen_in_whatever_order_they_are(tmp_path, order, ending):
    depth = np.full((24, 32), 1500).astype(order)
    depth[:, ::2] = 65535
    path = tmp_path / f"depth.{ending}"
    if ending == "npy":
        np.save(path, depth)
    elif ending == "npz":
        np.savez(path, depth=depth)
    else:
        Image.frombytes("I;16" if order == "<u2" else "I;16B", (32, 24), depth.tobytes()).save(path)
    found = read_scan(path, CAMERA, 1000.0)
    np.testing.assert_array_equal(found.places, np.flatnonzero(depth != 65535))
    assert set(found.points[:, 2]) == {1.5}


def test_intrinsics_of_a_larger_image_are_doubted(tmp_path):
    np.save(tmp_path / "small.npy", np.random.default_rng(1).uniform(1.0, 2.0, (24, 32)))
    assert read_scan(tmp_path / "small.npy", CAMERA).doubt is None
    doubt = read_scan(tmp_path / "small.npy", Intrinsics(525.0, 525.0, 319.5, 239.5)).doubt
    assert doubt is not None and "(319.5, 239.5) is outside of its 32 x 24 pixels" in doubt


@pytest.mark.parametrize("scale", [0.0, -1.0, np.nan, np.inf])
def test_a_depth_scale_is_above_zero(tmp_path, scale):
    np.save(tmp_path / "a.npy", np.ones((24, 32)))
    with pytest.raises(InputError, match="--depth-scale: expected a number above 0"):
        read_scan(tmp_path / "a.npy", CAMERA, scale)


@given(st.lists(st.integers(0, 9), min_size=1, max_size=400), st.integers(1, 12))
def test_places_are_counted_until_there_are_enough(values, enough):
    points = np.array(values, float)[:, None] * [1.0, 2.0, 3.0]
    count, every = count_places(points, enough), len(set(values))
    assert (count >= enough) == (every >= enough)
    assert count == every or enough <= count < every


@pytest.mark.parametrize(
    ("given", "option"), [({"intrinsics": CAMERA}, "--intrinsics"), ({"depth_scale": 1000.0}, "--depth-scale")]
)
def test_points_have_no_use_for_a_camera(tmp_path, given, option):
    np.savez(tmp_path / "scan.npz", points=POINTS)
    assert len(read_scan(str(tmp_path / "scan.npz"), **given, are_for_some=True).points)
    with pytest.raises(InputError, match=f"{option}: applies only to depth images; .*scan.npz holds points"):
        read_scan(tmp_path / "scan.npz", **given)


def test_intrinsics_that_are_given_take_the_place_of_those_in_the_file(tmp_path):
    depth = np.random.default_rng(1).uniform(1.0, 2.0, (24, 32))
    np.save(tmp_path / "bare.npy", depth)
    np.savez(tmp_path / "scan.npz", depth=depth, intrinsics=np.zeros(2))
    np.testing.assert_array_equal(
        read_scan(tmp_path / "scan.npz", CAMERA).points, read_scan(tmp_path / "bare.npy", CAMERA).points
    )


def test_intrinsics_are_four_numbers():
    assert Intrinsics.parse("100,110,15.5,11.5") == CAMERA
    for text in ("", "1,2,3", "a,b,c,d", "0,1,2,3", "-1,1,2,3", "1,1,nan,0"):
        with pytest.raises(InputError, match="--intrinsics: expected fx,fy,cx,cy"):
            Intrinsics.parse(text)


HEADERS = {"vast.npy": f"({10**30}, 3)", "true.npy": "(True, 3)"}
"""Shapes that arrays cannot have."""


def written(folder: Path, what: str) -> Path:
    path = folder / what
    if what == "objects.npy":
        np.save(path, np.array([{"a": 1}], dtype=object), allow_pickle=True)
    elif what == "words.npy":
        np.save(path, np.array(["a", "b"]))
    elif what == "few.npy":
        np.save(path, POINTS[:5])
    elif what == "one_place.npy":
        np.save(path, np.ones((64, 3)))
    elif what == "behind.npy":
        np.save(path, POINTS * [1.0, 1.0, -1.0])
    elif what == "member.npz":
        with ZipFile(path, "w") as archive:
            archive.writestr("points.npy", "no array")
    elif what == "shape.npz":
        np.savez(path, points=POINTS.T)
    elif what == "shape.npy":
        np.save(path, POINTS.T)
    elif what == "other.npz":
        np.savez(path, cloud=POINTS)
    elif what == "no_camera.npz":
        np.savez(path, depth=np.ones((8, 8)))
    elif what == "bad_camera.npz":
        np.savez(path, depth=np.ones((8, 8)), intrinsics=np.ones((2, 2)))
    elif what == "turned_camera.npz":
        np.savez(path, depth=np.ones((8, 8)), intrinsics=np.array([[100.0, 0.0, 4.0], [0.0, 100.0, 4.0], [0.0, 0.0, 1.0]]).T)
    elif what == "colours.npy":
        np.save(path, np.hstack([POINTS, POINTS]))
    elif what == "tiny.npy":
        np.save(path, 1e-12 * POINTS)
    elif what == "huge.npy":
        np.save(path, 1e300 * POINTS)
    elif what == "palette.png":
        Image.fromarray(np.full((64, 64), 7, np.uint8)).convert("P").save(path)
    elif what == "grey.png":
        Image.fromarray(np.full((64, 64), 7, np.uint8)).save(path)
    elif what == "fewer_than_none.ply":
        path.write_text("ply\nformat ascii 1.0\nelement vertex -5\nproperty float x\nproperty float y\nend_header\n")
    elif what == "chunk.png":
        Image.fromarray(np.arange(64 * 64, dtype=np.uint16).reshape(64, 64)).save(path)
        path.write_bytes(path.read_bytes().replace(b"IDAT", b"I\0AT"))
    elif what == "half.ply":
        points = "".join(f"{x} {y} {z}\n" for x, y, z in POINTS[:60])
        axes = "".join(f"property float {axis}\n" for axis in "xyz")
        path.write_text(f"ply\nformat ascii 1.0\nelement vertex {len(POINTS)}\n{axes}end_header\n{points}")
    elif what in HEADERS:
        header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {HEADERS[what]}, }}".encode().ljust(117) + b"\n"
        path.write_bytes(b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + POINTS.tobytes())
    elif what == "packed.npz":
        with ZipFile(path, "w", ZIP_LZMA) as archive:
            archive.writestr("points.npy", bytes(range(256)) * 99)
        whole = path.read_bytes()
        path.write_bytes(whole[:60] + bytes(byte ^ 0xFF for byte in whole[60:120]) + whole[120:])
    elif what == "empty.npy":
        np.save(path, np.full((64, 3), np.nan))
    else:
        path.write_bytes(b"nonsense")
    return path


@pytest.mark.parametrize(
    ("what", "problem"),
    [
        ("objects.npy", "expected arrays of NumPy"),
        ("words.npy", "expected numbers"),
        ("few.npy", "expected points at 32 places .* or more, got 5"),
        ("vast.npy", "expected arrays of NumPy"),
        ("true.npy", "expected arrays of NumPy"),
        ("packed.npz", "expected arrays of NumPy"),
        ("empty.npy", "got 0"),
        ("one_place.npy", "got 1"),
        ("behind.npy", "got 0"),
        ("member.npz", "expected arrays of NumPy|points: expected numbers"),
        ("shape.npz", r"points: expected \[n, 3\]"),
        ("shape.npy", r"points: expected \[n, 3\], got \[3, 100\]"),
        ("other.npz", "expected points or depth, got cloud"),
        ("no_camera.npz", "--intrinsics fx,fy,cx,cy"),
        ("bad_camera.npz", "intrinsics: expected the matrix"),
        ("turned_camera.npz", "intrinsics: expected the matrix"),
        ("colours.npy", r"points: expected \[n, 3\], got \[100, 6\]"),
        ("tiny.npy", "expected points that are 1e-06 to 1e[+]09 apart"),
        ("huge.npy", "expected points that are 1e-06 to 1e[+]09 apart"),
        ("palette.png", "expected depths, got an image with a palette"),
        ("grey.png", "expected depths of 16 bits or more, got an image of 8 bits"),
        ("fewer_than_none.ply", "expected a whole PLY file whose vertices have x, y and z"),
        ("cut.npz", r"expected arrays of NumPy \(it is none, or holds objects\)"),
        ("cut.ply", "expected a whole PLY file"),
        ("half.ply", "expected 100 points, as its header says, got 60"),
        ("cut.png", "expected a depth image"),
        ("chunk.png", "expected a depth image"),
        ("scan.xyz", "expected a scan: one of"),
    ],
)
def test_what_is_no_scan_is_named_in_one_line(tmp_path, what, problem):
    with pytest.raises(InputError, match=problem) as caught:
        read_scan(written(tmp_path, what))
    assert what in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_textured_ply_has_the_points_that_it_lists(tmp_path):
    axes = "".join(f"property float {axis}\n" for axis in "xyzst")
    rows = "".join(f"{x} {y} {z} 0.5 0.5\n" for x, y, z in POINTS)
    header = f"ply\nformat ascii 1.0\nelement vertex {len(POINTS)}\n{axes}element face 1\n"
    text = f"{header}property list uchar int vertex_indices\nend_header\n{rows}3 0 1 2\n"
    (tmp_path / "textured.ply").write_text(text)
    np.testing.assert_allclose(read_scan(tmp_path / "textured.ply").points, POINTS, rtol=1e-6)


def test_points_behind_the_camera_are_left_out_and_counted_and_those_at_none_are_not(tmp_path):
    behind, unknown = POINTS[:7] * [1.0, 1.0, -1.0], [[0.0, 0.0, 0.0], [np.nan, 0.0, -1.0]]
    np.save(tmp_path / "all.npy", np.vstack([behind, unknown, POINTS]))
    found = read_scan(tmp_path / "all.npy")
    np.testing.assert_array_equal(found.points, POINTS)
    assert found.places.tolist() == list(range(9, 109))
    assert found.behind == 7


def test_pixels_without_a_place_are_left_out_and_other_arrays_are_not_looked_at(tmp_path):
    cloud = np.concatenate([POINTS, np.zeros((50, 3)), np.full((50, 3), np.nan)])
    np.savez(tmp_path / "scan.npz", points=cloud, names=np.array(["a"], dtype=object), intrinsics="a camera's name")
    found = read_scan(tmp_path / "scan.npz")
    np.testing.assert_array_equal(found.points, POINTS)
    np.testing.assert_array_equal(found.places, np.arange(len(POINTS)))


def test_a_file_that_is_not_there_is_said_to_be_missing(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_scan(tmp_path / "none.npz")


@settings(max_examples=200)
@given(st.data())
def test_a_damaged_archive_is_refused_in_one_line_or_read(tmp_path_factory, data):
    whole = io.BytesIO()
    np.savez_compressed(whole, points=POINTS)
    contents = bytearray(whole.getvalue())
    place = data.draw(st.integers(0, len(contents) - 1))
    contents[place] ^= data.draw(st.integers(1, 255))
    path = tmp_path_factory.getbasetemp() / "damaged.npz"
    path.write_bytes(contents[: data.draw(st.sampled_from([None, place]))])
    try:
        assert read_scan(path).points.shape[1] == 3
    except InputError as error:
        assert "\n" not in str(error)
