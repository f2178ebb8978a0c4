"""Looks of USD meshes: UsdPreviewSurface materials, image files, texture coordinates, colours and normals."""

from __future__ import annotations

from typing import Any

import numpy as np

from kinmo.core.look import Look, Material, face_normals
from kinmo.core.names import unique_names
from kinmo.core.shape import Mesh
from kinmo.io.writers.robot_meshes import MESHES
from kinmo.io.writers.texture_images import GLTF_TYPES, Note, TextureImages

GREY = (0.7, 0.7, 0.7, 1.0)
"""Colour of faces without a material: red, green, blue and opacity."""
COORDINATES = "st"
"""Name of texture coordinates."""


class UsdLooks:
    """Adds looks to the meshes of a stage, each material once.

    Args:
        stage: the stage (`pxr.Usd.Stage`).
        place: path of the scope for the materials, which is made for the first one.
        materials: all materials of the object.
        textures: the image files.
        note: what receives a line about what USD cannot carry.
    """

    def __init__(self, stage: Any, place: Any, materials: list[Material], textures: TextureImages, note: Note) -> None:
        from pxr import Gf, Sdf, UsdGeom, UsdShade, Vt

        self._gf, self._types, self._geom, self._shade, self._vt = Gf, Sdf.ValueTypeNames, UsdGeom, UsdShade, Vt
        self._stage, self._place, self._textures, self._note = stage, place, textures, note
        names = unique_names(name for each in materials for name in (each.name or "material", f"{each.name}_colors"))
        self._names = {(each, way): names[2 * i + way] for i, each in enumerate(materials) for way in (False, True)}
        self._made: dict[tuple[Material, bool], Any] = {}

    def add(self, written: Any, mesh: Mesh) -> None:
        """Add the look of a mesh to a prim (`pxr.UsdGeom.Mesh`) with the same faces."""
        look = mesh.look
        self.add_normals(written, mesh)
        self._add_colors(written, look, len(mesh.faces))
        if look is None:
            return
        if look.uvs is not None:
            kind = self._types.TexCoord2fArray
            values, places = np.unique(_flat(look.uvs), axis=0, return_inverse=True)
            primvar = self._geom.PrimvarsAPI(written).CreatePrimvar(COORDINATES, kind, self._geom.Tokens.faceVarying)
            primvar.Set(self._vt.Vec2fArray.FromNumpy(values))
            primvar.SetIndices(self._vt.IntArray.FromNumpy(places.ravel().astype(np.int32)))
        used = look.used()
        for material, faces in used:
            if material is not None:
                prim = written.GetPrim() if len(used) == 1 else self._subset(written, material, np.flatnonzero(faces))
                self._shade.MaterialBindingAPI.Apply(prim).Bind(self._material(material, look.colors is not None))

    def add_normals(self, written: Any, mesh: Mesh) -> None:
        """Add the normals of a mesh, or those of its faces."""
        normals, way = face_normals(mesh.triangles).astype(np.float32), self._geom.Tokens.uniform
        if mesh.look is not None and mesh.look.normals is not None:
            normals, way = _flat(mesh.look.normals), self._geom.Tokens.faceVarying
        written.CreateNormalsAttr(self._vt.Vec3fArray.FromNumpy(normals))
        written.SetNormalsInterpolation(way)

    def _add_colors(self, written: Any, look: Look | None, count: int) -> None:
        """Colours for viewers without materials, and for materials that take their colour from vertices."""
        colors = np.tile(np.array(GREY, np.float32), (count, 1))
        for material, faces in [] if look is None else look.used():
            if material is not None:
                colors[faces] = material.base_color
        way = self._geom.Tokens.uniform
        if look is not None and look.colors is not None:
            white = np.where(look.material >= 0, 1.0, 0.0)[:, None]
            own = white * colors + (1.0 - white)
            colors, way = _flat(look.colors * own[:, None]), self._geom.Tokens.faceVarying
        elif not len(colors) or (colors == colors[0]).all():
            colors, way = colors[:1], self._geom.Tokens.constant
        shown = np.ascontiguousarray(colors[:, :3])
        written.CreateDisplayColorPrimvar(way).Set(self._vt.Vec3fArray.FromNumpy(shown))
        if (colors[:, 3] < 1.0).any():
            written.CreateDisplayOpacityPrimvar(way).Set(self._vt.FloatArray.FromNumpy(np.ascontiguousarray(colors[:, 3])))

    def _subset(self, written: Any, material: Material, faces: Any) -> Any:
        name = self._names[material, False]
        indices = self._vt.IntArray.FromNumpy(faces.astype(np.int32))
        family = self._shade.Tokens.materialBind
        subset = self._geom.Subset.CreateGeomSubset(written, name, self._geom.Tokens.face, indices, family)
        self._geom.Subset.SetFamilyType(written, family, self._geom.Tokens.nonOverlapping)
        return subset.GetPrim()

    def _material(self, material: Material, has_colors: bool) -> Any:
        file = None if material.image is None else self._textures.file(material.image, GLTF_TYPES)
        if file is not None and has_colors:
            self._note("the colours of vertices are left out where a material has an image")
            has_colors = False
        if (material, has_colors) not in self._made:
            self._geom.Scope.Define(self._stage, self._place)
            made = self._shade.Material.Define(self._stage, self._place.AppendChild(self._names[material, has_colors]))
            if material.name:
                made.GetPrim().SetDisplayName(material.name)
            self._made[material, has_colors] = made
            self._surface(made, material, file, has_colors)
        return self._made[material, has_colors]

    def _surface(self, made: Any, material: Material, file: str | None, has_colors: bool) -> None:
        types, alpha = self._types, material.base_color[3]
        surface = self._shader(made, "surface", "UsdPreviewSurface")
        surface.CreateInput("metallic", types.Float).Set(material.metallic)
        surface.CreateInput("roughness", types.Float).Set(material.roughness)
        if any(material.emissive):
            surface.CreateInput("emissiveColor", types.Color3f).Set(self._gf.Vec3f(*material.emissive))
        color = surface.CreateInput("diffuseColor", types.Color3f)
        opacity = None if material.alpha_mode == "OPAQUE" else surface.CreateInput("opacity", types.Float)
        if material.alpha_mode == "MASK":
            surface.CreateInput("opacityThreshold", types.Float).Set(material.alpha_cutoff)
        if file is not None:
            texture = self._texture(made, material, file)
            color.ConnectToSource(texture.CreateOutput("rgb", types.Float3))
            if opacity is not None:
                opacity.ConnectToSource(texture.CreateOutput("a", types.Float))
        else:
            if has_colors:
                reader = self._shader(made, "vertexColor", "UsdPrimvarReader_float3")
                reader.CreateInput("varname", types.String).Set("displayColor")
                color.ConnectToSource(reader.CreateOutput("result", types.Float3))
            else:
                color.Set(self._gf.Vec3f(*material.base_color[:3]))
            if opacity is not None:
                opacity.Set(alpha)
        made.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")

    def _texture(self, made: Any, material: Material, file: str) -> Any:
        types = self._types
        reader = self._shader(made, "coordinates", "UsdPrimvarReader_float2")
        reader.CreateInput("varname", types.String).Set(COORDINATES)
        texture = self._shader(made, "image", "UsdUVTexture")
        texture.CreateInput("file", types.Asset).Set(f"./{MESHES}/{file}")
        texture.CreateInput("sourceColorSpace", types.Token).Set("sRGB")
        for way in ("wrapS", "wrapT"):
            texture.CreateInput(way, types.Token).Set("repeat")
        texture.CreateInput("scale", types.Float4).Set(self._gf.Vec4f(*material.base_color))
        texture.CreateInput("st", types.Float2).ConnectToSource(reader.CreateOutput("result", types.Float2))
        return texture

    def _shader(self, made: Any, name: str, kind: str) -> Any:
        shader = self._shade.Shader.Define(self._stage, made.GetPath().AppendChild(name))
        shader.CreateIdAttr(kind)
        return shader


def _flat(corners: Any) -> Any:
    """Values [F, 3, width] of corners as one list [3 F, width] in single precision."""
    return np.ascontiguousarray(corners.reshape(-1, corners.shape[-1]), np.float32)
