"""The scene of a glTF file: its nodes with their meshes placed, instances and skins applied."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh, join
from kinmo.io.readers import scene as limits
from kinmo.io.readers.gltf_accessors import FLOAT, read_floats, read_numbers
from kinmo.io.readers.gltf_file import INSTANCING, GltfFile, extension
from kinmo.io.readers.gltf_materials import GltfMaterials
from kinmo.io.readers.gltf_primitives import Primitive, read_primitive
from kinmo.io.readers.image_files import MAX_NAMED
from kinmo.io.readers.json_field import JsonField
from kinmo.io.readers.part_hierarchy import check_depth
from kinmo.io.readers.scene import CornerBudget, SceneNode, placed

F64 = NDArray[np.float64]


class GltfScene:
    """The default scene of a glTF file.

    Attributes:
        nodes: the nodes in preorder, below one node that stands for the scene.
        unread: what was not read, with its count.
    """

    def __init__(self, file: GltfFile) -> None:
        self._file = file
        self._budget = CornerBudget(file.path)
        self._primitives: dict[int, list[Primitive]] = {}
        self._surfaces: dict[int, Mesh | None] = {}
        self.unread: Counter[str] = Counter()
        self._normals, self._empty = 0, 0
        self._materials = GltfMaterials(file, self._ignore)
        self._parents = {child.integer(): index for index, child in _child_fields(file)}
        self._poses: dict[int, F64] = {}
        self.nodes = tuple(self._scene_nodes())

    def _ignore(self, what: str) -> None:
        self.unread[what] += 1

    def _scene_nodes(self) -> list[SceneNode]:
        root = self._file.root
        found = [SceneNode("", None)]
        seen: set[int] = set()
        pending = [(field, 0, 1) for field in reversed(self._roots())]
        while pending:
            index, parent, depth = pending.pop()
            node = self._file.entry("nodes", index)
            check_depth(node, depth)
            if len(found) > limits.MAX_NODES:
                raise InputError(root.where, f"more than {limits.MAX_NODES} nodes")
            if index.integer() in seen:
                raise index.fail(f"node {index.integer()} is in two places")
            seen.add(index.integer())
            visibility = extension(node, "KHR_node_visibility")
            if not visibility.is_absent and visibility["visible"].value is False:
                self.unread["hidden nodes"] += 1
                continue
            place, name = len(found), node["name"].text("")
            meshes = self._placed_meshes(index.integer(), node)
            found.append(SceneNode(name, parent, meshes[0] if len(meshes) == 1 else None))
            if len(meshes) > 1:  # instances are parts beside each other, whatever is below the node
                found += [SceneNode(name, parent, mesh) for mesh in meshes]
            pending += [(child, place, depth + 1) for child in reversed(node["children"].items())]
        return found

    def _roots(self) -> list[JsonField]:
        """Indices of the root nodes of the default scene, or of the first scene. Without scenes, of all nodes."""
        root = self._file.root
        if root["scenes"].items():
            scene = root["scene"]
            chosen = root["scenes"].items()[0] if scene.is_absent else self._file.entry("scenes", scene)
            return chosen["nodes"].items()
        nodes = self._file.entries("nodes")
        return [JsonField(node.where, i, node.path) for i, node in enumerate(nodes) if i not in self._parents]

    def _placed_meshes(self, number: int, node: JsonField) -> list[Mesh]:
        """The mesh of a node in the scene, once for each of its instances. Empty if it has none."""
        if node["mesh"].is_absent:
            return []
        if not node["skin"].is_absent:
            mesh = self._skinned(number, node)
            return [] if mesh is None else [mesh]
        surface = self._surface(node["mesh"])
        if surface is None:
            return []
        pose = self._pose(number)
        instances = extension(node, INSTANCING)
        poses = [pose] if instances.is_absent else [pose @ one for one in self._instance_poses(instances)]
        found = []
        for one in poses:
            self._budget.spend(len(surface.vertices) + surface.faces.size)
            found.append(placed(self._with_normals_in_budget(surface), one, node.where))
        return found

    def _with_normals_in_budget(self, surface: Mesh) -> Mesh:
        """The mesh without its normals if those of all instances together are too many. All else is shared by instances."""
        if surface.look is None or surface.look.normals is None:
            return surface
        self._normals += surface.faces.size
        return surface if self._normals <= limits.MAX_CORNERS else replace(surface, look=replace(surface.look, normals=None))

    def _surface(self, index: JsonField) -> Mesh | None:
        """The triangles of a mesh in its own frame. None if it has none."""
        number = index.integer()
        if number not in self._surfaces:
            meshes = [primitive.mesh.compact for primitive in self._primitives_of(index)]
            self._surfaces[number] = join(*meshes) if meshes else None
        return self._surfaces[number]

    def _primitives_of(self, index: JsonField) -> list[Primitive]:
        number = index.integer()
        if number not in self._primitives:
            found = []
            mesh, is_empty = self._file.entry("meshes", index), True
            for field in mesh["primitives"].items():
                primitive = read_primitive(self._file, field, self._materials)
                if primitive is None:
                    self.unread["points and lines"] += 1
                    is_empty = False
                    continue
                self.unread["morph targets"] += len(field["targets"].items())
                self._budget.spend(len(primitive.mesh.vertices) + primitive.mesh.faces.size)
                if len(primitive.mesh.faces):
                    found.append(primitive)
            if is_empty and not found:
                self._empty += 1
                named = f"mesh {mesh['name'].text('') or number}, which has no triangles,"
                self.unread[named if self._empty <= MAX_NAMED else "further meshes without triangles"] += 1
            self._primitives[number] = found
        return self._primitives[number]

    def _skinned(self, number: int, node: JsonField) -> Mesh | None:
        """The mesh of a node with a skin, where the joints put it. The node's own transform moves no vertex that has joints."""
        skin = self._file.entry("skins", node["skin"])
        joints = skin["joints"].items()
        if not joints:
            raise skin["joints"].fail("expected at least one joint")
        poses = np.stack([self._pose_of(joint) for joint in joints])
        bind = skin["inverseBindMatrices"]
        if not bind.is_absent:
            matrices = read_numbers(self._file, bind, "MAT4", (FLOAT,)).astype(np.float64)
            if len(matrices) < len(joints):
                raise bind.fail(f"expected {len(joints)} matrices, got {len(matrices)}")
            poses = poses @ matrices[: len(joints)].reshape(-1, 4, 4).transpose(0, 2, 1)
        meshes = []
        for primitive in self._primitives_of(node["mesh"]):
            self._budget.spend(len(primitive.mesh.vertices))
            if primitive.joints is None:
                meshes.append(placed(primitive.mesh, self._pose(number), node.where).compact)
            else:
                meshes.append(_bent(primitive, poses, node).compact)
        return join(*meshes) if meshes else None

    def _pose(self, number: int) -> F64:
        """Transform [4, 4] from a node to the scene."""
        chain = []
        above: int | None = number
        while above is not None and above not in self._poses:
            chain.append(above)
            if len(chain) > limits.MAX_NODES:
                raise InputError(self._file.path, "expected a tree of nodes, found a cycle", f"nodes[{number}]")
            above = self._parents.get(above)
        pose = np.eye(4) if above is None else self._poses[above]
        for one in reversed(chain):
            pose = pose @ _local_pose(self._file.entries("nodes")[one])
            self._poses[one] = pose
        return pose

    def _pose_of(self, index: JsonField) -> F64:
        self._file.entry("nodes", index)
        return self._pose(index.integer())

    def _instance_poses(self, instances: JsonField) -> list[F64]:
        """Transforms [4, 4] of the instances of a node, to the node."""
        attributes = instances["attributes"]
        parts = {}
        for name, kind in (("TRANSLATION", "VEC3"), ("ROTATION", "VEC4"), ("SCALE", "VEC3")):
            if not attributes[name].is_absent:
                parts[name] = read_floats(self._file, attributes[name], kind)
        counts = {len(values) for values in parts.values()}
        if len(counts) != 1:
            problem = f"{INSTANCING} needs translations, rotations or scales, the same number of each: export without it"
            raise attributes.fail(problem)
        (count,) = counts
        if count > limits.MAX_NODES:
            raise attributes.fail(f"more than {limits.MAX_NODES} instances")
        linear = np.tile(np.eye(3), (count, 1, 1))
        if "ROTATION" in parts:
            if np.any(np.linalg.norm(parts["ROTATION"], axis=1) == 0.0):
                raise attributes["ROTATION"].fail("expected quaternions")
            linear = Rotation.from_quat(parts["ROTATION"]).as_matrix()
        poses = np.tile(np.eye(4), (count, 1, 1))
        poses[:, :3, :3] = linear * parts.get("SCALE", np.ones((count, 3)))[:, None, :]
        poses[:, :3, 3] = parts.get("TRANSLATION", np.zeros((count, 3)))
        return list(poses)


def _child_fields(file: GltfFile) -> list[tuple[int, JsonField]]:
    """The parent's index and the field of every child, in the whole file."""
    return [(index, child) for index, node in enumerate(file.entries("nodes")) for child in node["children"].items()]


def _local_pose(node: JsonField) -> F64:
    """Transform [4, 4] from a node to its parent."""
    if not node["matrix"].is_absent:
        return np.asarray(node["matrix"].vector(16).reshape(4, 4).T)
    pose = np.eye(4)
    if not node["rotation"].is_absent:
        quaternion = node["rotation"].vector(4)
        if not np.linalg.norm(quaternion) > 0.0:
            raise node["rotation"].fail("expected a quaternion")
        pose[:3, :3] = Rotation.from_quat(quaternion).as_matrix()
    if not node["scale"].is_absent:
        pose[:3, :3] *= node["scale"].vector(3)
    if not node["translation"].is_absent:
        pose[:3, 3] = node["translation"].vector(3)
    return pose


def _bent(primitive: Primitive, poses: F64, node: JsonField) -> Mesh:
    """The triangles of a primitive in the scene. The weighted mean of the poses [J, 4, 4] of its joints moves each vertex.

    Triangles that the poses mirror are flipped, so that they still face outwards.
    """
    joints, weights = primitive.joints, primitive.weights
    assert joints is not None and weights is not None
    weights = np.maximum(weights, 0.0)
    if int(joints[weights > 0.0].max(initial=0)) >= len(poses):
        raise node["skin"].fail(f"its mesh names a joint outside 0..{len(poses) - 1}")
    total = weights.sum(axis=1, keepdims=True)
    weights = np.where(total > 0.0, weights / np.where(total > 0.0, total, 1.0), 0.0)
    weights[total[:, 0] == 0.0, 0] = 1.0  # vertices without weights follow their first joint
    corners = np.column_stack([primitive.mesh.vertices, np.ones(len(weights))])
    vertices, linear = np.zeros((len(weights), 3)), None
    with np.errstate(over="ignore", invalid="ignore"):
        if np.any(np.linalg.det(poses[:, :3, :3]) < 0.0):
            linear = np.zeros((len(weights), 3, 3))
        for column in range(weights.shape[1]):
            chosen = np.minimum(joints[:, column], len(poses) - 1)
            for joint in np.unique(chosen[weights[:, column] > 0.0]):
                rows = (chosen == joint) & (weights[:, column] > 0.0)
                vertices[rows] += weights[rows, column, None] * (corners[rows] @ poses[joint, :3].T)
                if linear is not None:
                    linear[rows] += weights[rows, column, None, None] * poses[joint, :3, :3]
        is_mirrored = None if linear is None else np.linalg.det(linear) < 0.0
    if not np.isfinite(vertices).all():
        raise node["skin"].fail("expected transforms that give finite positions")
    look = primitive.mesh.look
    mesh = Mesh(vertices, primitive.mesh.faces, None if look is None else replace(look, normals=None))
    return mesh if is_mirrored is None else _flipped(mesh, is_mirrored[mesh.faces].sum(axis=1) >= 2)


def _flipped(mesh: Mesh, chosen: NDArray[np.bool_]) -> Mesh:
    """A mesh where the corners of the chosen faces [F] are in reverse order."""
    faces = np.arange(len(mesh.faces))
    return join(mesh, mesh.flipped).part(np.where(chosen, len(faces) + faces, faces))
