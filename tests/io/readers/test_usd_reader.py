"""USD files whose layers are not there, or are in folders and packages."""

from __future__ import annotations

from pathlib import Path

import pytest

import kinmo
from kinmo.io.discover import discover
from kinmo.io.source_files import fingerprint

pytest.importorskip("pxr")

STAGE = """#usda 1.0
(
    {layers}
)
def Xform "chest"
{{
    def Cube "body"
    {{
    }}
    def Sphere "knob"
    {{
        double radius = 3
    }}
    def Xform "door" ( {door} )
    {{
    }}
}}
"""


def stage(path: Path, door: str = "", layers: str = "") -> Path:
    path.write_text(STAGE.format(door=door, layers=layers))
    return path


@pytest.mark.parametrize("arc", ["references", "payload"])
def test_a_missing_asset_is_named_in_the_repairs_alone(arc: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (found,) = discover(stage(tmp_path / "a.usda", f"prepend {arc} = @gone/door.usda@"))
    shape = found.read()
    assert len(shape.leaves) == 2
    assert shape.repairs == ("asset gone/door.usda (cannot be opened) ignored: 1",)
    assert [row[0] for row in fingerprint(found)] == ["a.usda"]
    assert capfd.readouterr() == ("", "")


def test_a_missing_sublayer_is_named(tmp_path: Path) -> None:
    shape = kinmo.load(stage(tmp_path / "a.usda", layers="subLayers = [@gone.usda@]"))
    assert shape.repairs == ("asset gone.usda (cannot be opened) ignored: 1",)


def test_a_reference_to_a_missing_prim_is_named(tmp_path: Path) -> None:
    shape = kinmo.load(stage(tmp_path / "a.usda", "references = </nothing>"))
    problem = "Unresolved reference prim path @a.usda@</nothing> introduced by @a.usda@</chest/door>"
    assert shape.repairs == (f"{problem} ignored: 1",)


def test_many_missing_assets_are_counted(tmp_path: Path) -> None:
    assets = ", ".join(f"@gone{number}.usda@" for number in range(8))
    shape = kinmo.load(stage(tmp_path / "a.usda", f"references = [{assets}]"))
    assert len(shape.repairs) == 6
    assert "further layers and prims that cannot be found ignored: 3" in shape.repairs


def test_a_broken_layer_is_named(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "door.usda").write_text("#usda 1.0\ndef {")
    shape = kinmo.load(stage(tmp_path / "a.usda", "references = @./door.usda@"))
    assert shape.repairs == ("asset door.usda (cannot be opened) ignored: 1",)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("folder", ["v[1]", "[old] model", "a]b[c", "x[y.usdz"])
def test_brackets_in_the_name_of_a_folder_change_nothing(folder: str, tmp_path: Path) -> None:
    inner = tmp_path / folder
    inner.mkdir()
    stage(inner / "b.usda")
    (found,) = discover(stage(inner / "a.usda", layers="subLayers = [@./b.usda@]"))
    assert len(found.read().leaves) == 2
    assert [row[0] for row in fingerprint(found)] == ["a.usda", "b.usda"]


@pytest.mark.parametrize("folder", ["plain", "v[1]"])
def test_a_package_is_one_file(folder: str, tmp_path: Path) -> None:
    from pxr import UsdUtils

    inner = tmp_path / folder
    inner.mkdir()
    assert UsdUtils.CreateNewUsdzPackage(str(stage(tmp_path / "b.usda")), str(inner / "b.usdz"))
    (packed,) = discover(inner / "b.usdz")
    assert len(packed.read().leaves) == 2
    assert [row[0] for row in fingerprint(packed)] == ["b.usdz"]
    (found,) = discover(stage(inner / "a.usda", "references = @./b.usdz@</chest>"))
    assert len(found.read().leaves) == 4
    assert [row[0] for row in fingerprint(found)] == ["a.usda", "b.usdz"]


def test_a_layer_outside_a_folder_with_brackets_is_still_refused(tmp_path: Path) -> None:
    (tmp_path / "v[1]").mkdir()
    stage(tmp_path / "b.usda")
    path = stage(tmp_path / "v[1]" / "a.usda", layers="subLayers = [@../b.usda@]")
    with pytest.raises(kinmo.InputError, match=r"b\.usda: leads out of the folder of the file"):
        kinmo.load(path)
