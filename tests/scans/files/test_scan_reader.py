"""Users' scans from all kinds of files, and errors for files that hold none."""

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
from kinmo.scans.files import scan_formats
from kinmo.scans.files.camera_intrinsics import Intrinsics
from kinmo.scans.files.scan_reader import count_distinct_points, read_scan
from kinmo.scans.rendering.pinhole_camera import Camera

POINTS = np.random.default_rng(0).uniform(0.5, 1.5, (100, 3))
CAMERA = Intrinsics(100.0, 110.0, 15.5, 11.5)


def test_points_are_read_from_arrays_and_ply(tmp_path):
    np.save(tmp_path / "a.npy", POINTS)
    np.savez(tmp_path / "b.npz", points=POINTS.astype(np.float32))
    trimesh.PointCloud(POINTS).export(tmp_path / "c.ply")
    for name in ("a.npy", "b.npz", "c.ply"):
        np.testing.assert_allclose(read_scan(tmp_path / name).points, POINTS, atol=1e-6)


def test_a_depth_image_gives_the_points_of_its_camera(tmp_path):
    camera = Camera(32, 24, np.array([100.0, 110.0]), np.array([16.0, 12.0]), 0.1, 10.0)
    depth = np.random.default_rng(1).uniform(1.0, 2.0, (24, 32))
    depth[3, 4], depth[5, 6] = 0.0, np.nan
    millimetres = np.round(np.nan_to_num(depth) * 1000.0).astype(np.uint16)
    millimetres[5, 6] = 65535  # the mark of depths out of range
    seen = np.flatnonzero(np.nan_to_num(depth.ravel()) > 0.0)
    expected = camera.back_project(depth.ravel()[seen], seen)
    matrix = [[100.0, 0.0, 15.5], [0.0, 110.0, 11.5], [0.0, 0.0, 1.0]]
    np.savez(tmp_path / "with.npz", depth=depth, intrinsics=matrix)
    np.save(tmp_path / "bare.npy", depth)
    Image.fromarray(millimetres).save(tmp_path / "image.png")
    np.testing.assert_allclose(read_scan(tmp_path / "with.npz").points, expected)
    np.testing.assert_array_equal(read_scan(tmp_path / "with.npz").indices, seen)
    np.testing.assert_allclose(read_scan(tmp_path / "bare.npy", CAMERA).points, expected)
    np.testing.assert_allclose(read_scan(tmp_path / "image.png", CAMERA, 1000.0).points, expected, atol=2e-3)


@pytest.mark.parametrize("order", ["<u2", ">u2"])
@pytest.mark.parametrize("ending", ["npy", "npz", "tif"])
def test_the_largest_16_bit_depth_is_out_of_range_in_both_byte_orders(tmp_path, order, ending):
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
    np.testing.assert_array_equal(found.indices, np.flatnonzero(depth != 65535))
    assert set(found.points[:, 2]) == {1.5}


def test_intrinsics_of_a_larger_image_give_a_warning(tmp_path):
    np.save(tmp_path / "small.npy", np.random.default_rng(1).uniform(1.0, 2.0, (24, 32)))
    assert read_scan(tmp_path / "small.npy", CAMERA).warning is None
    warning = read_scan(tmp_path / "small.npy", Intrinsics(525.0, 525.0, 319.5, 239.5)).warning
    assert warning is not None and "(319.5, 239.5) is outside of its 32 x 24 pixels" in warning


@pytest.mark.parametrize("scale", [0.0, -1.0, np.nan, np.inf])
def test_a_depth_scale_must_be_positive(tmp_path, scale):
    np.save(tmp_path / "a.npy", np.ones((24, 32)))
    with pytest.raises(InputError, match="--depth-scale: expected a number above 0"):
        read_scan(tmp_path / "a.npy", CAMERA, scale)


@given(st.lists(st.integers(0, 9), min_size=1, max_size=400), st.integers(1, 12))
def test_distinct_points_are_counted_until_there_are_enough(values, enough):
    points = np.array(values, float)[:, None] * [1.0, 2.0, 3.0]
    count, every = count_distinct_points(points, enough), len(set(values))
    assert (count >= enough) == (every >= enough)
    assert count == every or enough <= count < every


@pytest.mark.parametrize(
    ("given", "option"), [({"intrinsics": CAMERA}, "--intrinsics"), ({"depth_scale": 1000.0}, "--depth-scale")]
)
def test_options_of_depth_images_are_errors_for_points(tmp_path, given, option):
    np.savez(tmp_path / "scan.npz", points=POINTS)
    assert len(read_scan(str(tmp_path / "scan.npz"), **given, ignore_unused_options=True).points)
    with pytest.raises(InputError, match=f"{option}: applies only to depth images; .*scan.npz holds points"):
        read_scan(tmp_path / "scan.npz", **given)


def test_given_intrinsics_override_those_in_the_file(tmp_path):
    depth = np.random.default_rng(1).uniform(1.0, 2.0, (24, 32))
    np.save(tmp_path / "bare.npy", depth)
    np.savez(tmp_path / "scan.npz", depth=depth, intrinsics=np.zeros(2))
    np.testing.assert_array_equal(
        read_scan(tmp_path / "scan.npz", CAMERA).points, read_scan(tmp_path / "bare.npy", CAMERA).points
    )


def test_intrinsics_are_parsed_from_four_numbers():
    assert Intrinsics.parse("100,110,15.5,11.5") == CAMERA
    for text in ("", "1,2,3", "a,b,c,d", "0,1,2,3", "-1,1,2,3", "1,1,nan,0"):
        with pytest.raises(InputError, match="--intrinsics: expected fx,fy,cx,cy"):
            Intrinsics.parse(text)


def test_arrays_that_unpack_to_too_much_are_an_error(tmp_path, monkeypatch):
    monkeypatch.setattr(scan_formats, "MAX_SCAN_BYTES", 1 << 20)
    np.savez_compressed(tmp_path / "a.npz", points=np.zeros((100_000, 3)))
    assert (tmp_path / "a.npz").stat().st_size < 1 << 20
    with pytest.raises(InputError, match="unpacks to more than 1 MiB"):
        read_scan(tmp_path / "a.npz")


HEADERS = {"vast.npy": f"({10**30}, 3)", "true.npy": "(True, 3)"}
"""Impossible shapes of arrays, by file name."""


def write_bad_scan(folder: Path, what: str) -> Path:
    """A file that is no scan, for the reason in its name."""
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
    elif what in ("vast.png", "vast.tif"):
        whole = io.BytesIO()
        Image.fromarray(np.zeros((100, 100), np.uint16)).save(whole, "PNG" if what == "vast.png" else "TIFF")
        side = (100).to_bytes(4, "big" if what == "vast.png" else "little")
        path.write_bytes(whole.getvalue().replace(side, (20_000).to_bytes(4, "big" if what == "vast.png" else "little"), 2))
    elif what == "pointer.npz":
        path.write_text("version https://git-lfs.github.com/spec/v1\n")
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
        ("vast.png", "expected a"),
        ("vast.tif", "expected a"),
        ("pointer.npz", "git lfs pull"),
    ],
)
def test_a_file_without_a_scan_gives_an_error_of_one_line(tmp_path, what, problem):
    with pytest.raises(InputError, match=problem) as caught:
        read_scan(write_bad_scan(tmp_path, what))
    assert what in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_textured_ply_gives_the_points_that_it_lists(tmp_path):
    axes = "".join(f"property float {axis}\n" for axis in "xyzst")
    rows = "".join(f"{x} {y} {z} 0.5 0.5\n" for x, y, z in POINTS)
    header = f"ply\nformat ascii 1.0\nelement vertex {len(POINTS)}\n{axes}element face 1\n"
    text = f"{header}property list uchar int vertex_indices\nend_header\n{rows}3 0 1 2\n"
    (tmp_path / "textured.ply").write_text(text)
    np.testing.assert_allclose(read_scan(tmp_path / "textured.ply").points, POINTS, rtol=1e-6)


def test_points_behind_the_camera_are_left_out_and_counted(tmp_path):
    behind, unknown = POINTS[:7] * [1.0, 1.0, -1.0], [[0.0, 0.0, 0.0], [np.nan, 0.0, -1.0]]
    np.save(tmp_path / "all.npy", np.vstack([behind, unknown, POINTS]))
    found = read_scan(tmp_path / "all.npy")
    np.testing.assert_array_equal(found.points, POINTS)
    assert found.indices.tolist() == list(range(9, 109))
    assert found.behind_count == 7


def test_unknown_points_are_left_out_and_other_arrays_ignored(tmp_path):
    cloud = np.concatenate([POINTS, np.zeros((50, 3)), np.full((50, 3), np.nan)])
    np.savez(tmp_path / "scan.npz", points=cloud, names=np.array(["a"], dtype=object), intrinsics="a camera's name")
    found = read_scan(tmp_path / "scan.npz")
    np.testing.assert_array_equal(found.points, POINTS)
    np.testing.assert_array_equal(found.indices, np.arange(len(POINTS)))


def test_a_missing_file_is_an_error(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_scan(tmp_path / "none.npz")


@settings(max_examples=200)
@given(st.data())
def test_a_damaged_archive_is_read_or_gives_an_error_of_one_line(tmp_path_factory, data):
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
