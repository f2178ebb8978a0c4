"""USD: the prims of the stage are the parts. usd-core reads the file (`pip install 'kinmo[usd]'`)."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh, Shape, join
from kinmo.core.wording import clean_text
from kinmo.io.readers import solids
from kinmo.io.readers.image_files import MAX_NAMED
from kinmo.io.readers.optional_library import optional_library
from kinmo.io.readers.polygons import triangulate
from kinmo.io.readers.reader import Reader, SourceFiles
from kinmo.io.readers.scene import F64, MAX_NODES, Scene, SceneBuilder, placed
from kinmo.io.readers.scene_shape import id_by_ending, shape_of_scene
from kinmo.io.readers.stated_facts import NO_FACTS, StatedFacts
from kinmo.io.readers.untrusted_files import MAX_SCENE_BYTES, check_no_pointer, inside, read_beginning

USD = "usd"
_ENDINGS = (".usd", ".usda", ".usdc", ".usdz")
_TURNS = {"X": (2, 0, 1), "Y": (1, 2, 0), "Z": (0, 1, 2)}
"""Order of the coordinates of a solid along z that puts it along another axis."""

_MISSING_ASSET = re.compile(r"Could not (?:open asset|load sublayer) @(.+?)@")


def read_usd(path: Path, facts: StatedFacts = NO_FACTS) -> Shape:
    """Read a USD file (see `shape_of_scene`)."""
    return shape_of_scene(read_usd_scene(Path(path)), facts)


def read_usd_scene(path: Path) -> Scene:
    """The scene of a USD stage at its first moment, without invisible prims, guides and proxies."""
    begin = read_beginning(path, path.parent, 64)
    if not begin:
        raise InputError(path, "empty")
    check_no_pointer(begin, path)
    if path.stat().st_size > MAX_SCENE_BYTES:
        raise InputError(path, f"larger than {MAX_SCENE_BYTES >> 20} MiB")
    optional_library("pxr", "usd", path, "is USD")
    try:
        with _without_warnings():
            return _UsdScene(path).scene()
    except InputError:
        raise
    except Exception as error:  # usd-core raises errors of its own kinds
        first = error.args[0] if error.args else error
        problem = getattr(first, "commentary", str(first))
        raise InputError(path, f"expected a readable USD file ({problem})") from None


@contextmanager
def _without_warnings() -> Iterator[None]:
    """Keep usd-core from writing warnings to the terminal. Its errors are still raised."""
    from pxr import UsdUtils

    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        yield
    finally:
        delegate.TakeUncoalescedDiagnostics()
        del delegate


class _UsdScene:
    """The visible prims of a stage."""

    def __init__(self, path: Path) -> None:
        from pxr import Usd, UsdGeom

        self.usd, self.geom = Usd, UsdGeom
        self.stage = Usd.Stage.Open(str(path))
        for layer in self.stage.GetUsedLayers():
            if layer.realPath:
                file = _file_of(layer.identifier)
                try:
                    inside(Path(file), path.parent)
                except InputError:
                    problem = f"{file}: leads out of the folder of the file: write one file, by `usdcat --flatten -o flat.usdc`"
                    raise InputError(path, clean_text(problem), "layers") from None
        self.time = Usd.TimeCode.EarliestTime()
        self.poses = UsdGeom.XformCache(self.time)
        self.builder = SceneBuilder(path)
        for count, problem in enumerate(self.stage.GetCompositionErrors()):
            named = _unresolved(str(problem), path.parent)
            self.builder.ignore(named if count < MAX_NAMED else "further layers and prims that cannot be found")

    def scene(self) -> Scene:
        pending = [(child, 0) for child in reversed(self._children(self.stage.GetPseudoRoot()))]
        while pending:
            prim, parent = pending.pop()
            if not self._is_shown(prim):
                continue
            name = prim.GetDisplayName() or prim.GetName()
            if prim.GetTypeName() == "Material":
                self.builder.ignore("materials")
            if prim.IsA(self.geom.PointInstancer):
                for instance in self._instances(prim):
                    self.builder.add(name, parent, instance)
                continue
            mesh = self._mesh(prim)
            place = self.builder.add(name, parent, mesh, None if mesh is None else self._pose(prim))
            pending += [(child, place) for child in reversed(self._children(prim))]
        up = "z" if self.geom.GetStageUpAxis(self.stage) == self.geom.Tokens.z else "y"
        return self.builder.scene(USD, "USD", "z" if up == "z" else "y", self._metres_per_unit())

    def _metres_per_unit(self) -> float:
        """Length of a unit. `GetStageMetersPerUnit` refuses numbers of single precision, which some tools write."""
        stated = self.stage.GetPseudoRoot().GetMetadata("metersPerUnit")
        return float(stated) if isinstance(stated, float | int) else float(self.geom.LinearUnits.centimeters)

    def _children(self, prim: Any) -> list[Any]:
        return list(prim.GetFilteredChildren(self.usd.TraverseInstanceProxies(self.usd.PrimDefaultPredicate)))

    def _is_shown(self, prim: Any) -> bool:
        shown = self.geom.Imageable(prim)
        if not shown:
            return True
        if shown.GetVisibilityAttr().Get(self.time) == self.geom.Tokens.invisible:
            self.builder.ignore("invisible prims")
            return False
        return shown.GetPurposeAttr().Get() not in (self.geom.Tokens.proxy, self.geom.Tokens.guide)

    def _pose(self, prim: Any) -> F64:
        """Transform [4, 4] from a prim to the scene."""
        return np.asarray(np.array(self.poses.GetLocalToWorldTransform(prim), np.float64).T)

    def _mesh(self, prim: Any) -> Mesh | None:
        """The triangles of a prim in its own frame. None if it has none."""
        if prim.IsA(self.geom.Mesh):
            return self._polygons(prim)
        if prim.IsA(self.geom.Gprim):
            found = self._solid(prim)
            if found is None:
                self.builder.ignore("points and curves")
            return found
        return None

    def _polygons(self, prim: Any) -> Mesh | None:
        mesh = self.geom.Mesh(prim)
        values = [
            attribute.Get(self.time)
            for attribute in (mesh.GetPointsAttr(), mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr())
        ]
        if any(value is None or not len(value) for value in values):
            return None
        vertices = np.array(values[0], np.float64).reshape(-1, 3)
        sizes, corners = (np.array(value, np.int64) for value in values[1:])
        if sizes.min() < 0 or sizes.sum() != len(corners) or corners.min() < 0 or corners.max() >= len(vertices):
            raise InputError(self.builder.path, f"{prim.GetPath()}: expected faces of {len(vertices)} points")
        if prim.HasRelationship("skel:skeleton"):
            self.builder.ignore("skeletons (bind pose)")
        faces = triangulate(vertices, corners, sizes, self.builder.path)[0].astype(np.uint32)
        if mesh.GetOrientationAttr().Get() == self.geom.Tokens.leftHanded:
            faces = faces[:, ::-1]
        return Mesh(vertices, faces)

    def _solid(self, prim: Any) -> Mesh | None:
        """The triangles of a cube, sphere, cylinder, cone or capsule."""
        geom = self.geom
        if prim.IsA(geom.Cube):
            return solids.box(np.full(3, geom.Cube(prim).GetSizeAttr().Get(self.time)))
        if prim.IsA(geom.Sphere):
            return solids.ellipsoid(np.full(3, geom.Sphere(prim).GetRadiusAttr().Get(self.time)))
        for kind, make in ((geom.Cylinder, solids.cylinder), (geom.Cone, solids.cone), (geom.Capsule, solids.capsule)):
            if prim.IsA(kind):
                shape = kind(prim)
                solid = make(shape.GetRadiusAttr().Get(self.time), shape.GetHeightAttr().Get(self.time))
                return Mesh(solid.vertices[:, _TURNS[str(shape.GetAxisAttr().Get())]], solid.faces)
        return None

    def _instances(self, prim: Any) -> Iterator[Mesh]:
        """The placed meshes of the instances of a PointInstancer."""
        instancer = self.geom.PointInstancer(prim)
        targets = instancer.GetPrototypesRel().GetForwardedTargets()
        prototypes = [self._prototype(self.stage.GetPrimAtPath(target)) for target in targets]
        indices = np.array(instancer.GetProtoIndicesAttr().Get(self.time) or [], np.int64)
        poses = instancer.ComputeInstanceTransformsAtTime(self.time, self.time, applyMask=instancer.IgnoreMask)
        if len(indices) > MAX_NODES or len(poses) != len(indices):
            raise InputError(self.builder.path, f"{prim.GetPath()}: expected at most {MAX_NODES} instances with transforms")
        shown = instancer.ComputeMaskAtTime(self.time)
        above = self._pose(prim)
        for place, (index, pose) in enumerate(zip(indices.tolist(), poses, strict=True)):
            if not 0 <= index < len(prototypes):
                raise InputError(
                    self.builder.path, f"{prim.GetPath()}: expected prototypes below {len(prototypes)}, got {index}"
                )
            mesh = prototypes[index]
            if mesh is not None and (not shown or shown[place]):
                yield placed(mesh, above @ np.array(pose, np.float64).T, self.builder.path)

    def _prototype(self, root: Any) -> Mesh | None:
        """All triangles at or below a prim, in its own frame."""
        inverse = np.linalg.inv(self._pose(root))
        found = []
        pending = [root]
        while pending:
            prim = pending.pop()
            mesh = self._mesh(prim) if self._is_shown(prim) else None
            if mesh is not None:
                found.append(placed(mesh, inverse @ self._pose(prim), self.builder.path))
            pending += reversed(self._children(prim))
        return join(*found) if found else None


def _file_of(layer: str) -> str:
    """The file of a layer, without the place in a package (usdz) and without arguments. Folders may have brackets too."""
    from pxr import Ar, Sdf

    path, _ = Sdf.Layer.SplitIdentifier(layer)
    return str(Ar.SplitPackageRelativePathOuter(path)[0])


def _unresolved(problem: str, folder: Path) -> str:
    """Subject of a composition error of usd-core, without the place of the folder."""
    text = problem.replace(f"{folder.absolute()}{os.sep}", "").rstrip(".")
    found = _MISSING_ASSET.match(text)
    return f"asset {clean_text(found[1])} (cannot be opened)" if found else clean_text(text)


def _source_files(path: Path) -> SourceFiles:
    """The file and the layers that it refers to."""
    files = [path]
    try:
        from pxr import UsdUtils

        with _without_warnings():
            layers, _, _ = UsdUtils.ComputeAllDependencies(str(path))
        files += [Path(_file_of(layer.realPath)) for layer in layers if layer.realPath]
    except Exception:  # missing library or broken file: reading names the problem
        pass
    return path.absolute().parent, list(dict.fromkeys(files))


READER = Reader(USD, read_usd, _source_files, id_of_file=id_by_ending(_ENDINGS), endings=_ENDINGS, read_stated=read_usd)
