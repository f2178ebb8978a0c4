"""A page of viser that shows one object, moves its joints, and takes corrections."""

from __future__ import annotations

import threading
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo.api.prediction import Prediction
from kinmo.core.errors import InputError
from kinmo.core.frames import quaternion
from kinmo.core.shape import Shape, join
from kinmo.io.writers.glb_writer import glb_bytes
from kinmo.robot.robot import Robot
from kinmo.view.corrections import Corrections
from kinmo.view.joint_panels import JointPanels
from kinmo.view.object_scene import ObjectScene
from kinmo.view.scene_building import scene_of
from kinmo.view.smooth_surface import with_sharp_creases

HOST, PORT = "127.0.0.1", 8080
"""Address of the page. Other machines cannot see it."""


class ObjectServer:
    """A running page of one object.

    Args:
        item: A prediction, or a shape with its own joints.
        folder: Folder of joints.json, where corrections are saved. None for no saving.
        host: Address that the page listens at. "0.0.0.0" lets other machines see it.
        port: Port of the page. If it is taken, the next free one is used.

    Raises:
        InputError: viser is not installed, or an overrides.toml in `folder` is wrong.

    Attributes:
        url: Address of the page.
        scene: The object as it is shown.
        nodes: Nodes of viser for each body, in its colour and as it looks.

    Example:
        >>> server = ObjectServer(prediction)
        >>> server.url
        'http://127.0.0.1:8080'
        >>> server.stop()
    """

    def __init__(self, item: Prediction | Shape, folder: Path | None = None, *, host: str = HOST, port: int = PORT) -> None:
        viser = _viser()
        self.corrections = None if isinstance(item, Shape) else Corrections.of(item, folder)
        self.scene = scene_of(item if self.corrections is None else self.corrections.prediction)
        self.values: dict[int, float] = {}
        self._lock = threading.RLock()
        low, high = self.scene.bounds
        self._scale = 2.0 / max(float(np.linalg.norm(high - low)), np.finfo(float).tiny)
        self._offset = -self._scale * 0.5 * (low + high)
        with redirect_stdout(StringIO()):  # viser prints a banner
            self.server = viser.ViserServer(host=host, port=port, label=f"kinmo: {self.scene.name}", verbose=False)
        shown = "127.0.0.1" if host in ("0.0.0.0", "::") else host
        self.url = f"http://{shown}:{self.server.get_port()}"
        self.nodes: list[list[Any]] = []
        self._arrows: list[Any] = []
        self._has_axes = True
        self._build_scene()
        self.panels = JointPanels(self)
        self.show()

    @property
    def placement(self) -> tuple[float, NDArray[np.float64]]:
        """Scale and offset [3] from the frame of the scene to that of the page, where every object has the same size."""
        return self._scale, self._offset

    def stop(self) -> None:
        """End the page."""
        with redirect_stdout(StringIO()):
            self.server.stop()

    def show(self) -> None:
        """Move everything to the present joint values."""
        with self._lock, self.server.atomic():
            poses = self.scene.poses(self.values)
            for index, body in enumerate(self.scene.bodies):
                for node in self.nodes[index]:
                    self._place(node, poses[index])
                if self._arrows[index] is not None:
                    self._place(self._arrows[index], np.eye(4) if body.parent is None else poses[body.parent])

    def set_value(self, index: int, value: float) -> None:
        """Move the joint of a body to a value, in radians or lengths."""
        with self._lock:
            self.values[index] = value
            self.show()

    def correct(self, scene: ObjectScene) -> None:
        """Show other joints of the same bodies."""
        with self._lock, self.server.atomic():
            self.scene = scene
            self.values = {index: value for index, value in self.values.items() if self._moves(index)}
            for index in self.values:
                self.values[index] = float(np.clip(self.values[index], *scene.range_of(index)))
            for index, arrow in enumerate(self._arrows):
                if arrow is not None:
                    arrow.remove()
                self._arrows[index] = self._arrow(index)
            self.show()

    def set_looks(self, has_looks: bool) -> None:
        """Show the materials of the file, or the colours of the bodies."""
        with self._lock, self.server.atomic():
            for colored, *looks in self.nodes:
                colored.visible = not has_looks or not looks
                for node in looks:
                    node.visible = has_looks

    def set_axes(self, has_axes: bool) -> None:
        """Show or hide the axes."""
        with self._lock:
            self._has_axes = has_axes
            for arrow in self._arrows:
                if arrow is not None:
                    arrow.visible = has_axes

    def _moves(self, index: int) -> bool:
        return self.scene.bodies[index].joint is not None

    def _build_scene(self) -> None:
        scene = self.server.scene
        scene.set_up_direction("+y")
        front = self.scene.front
        side = np.cross([0.0, 1.0, 0.0], front)
        self.server.initial_camera.position = tuple(1.9 * front - 1.0 * side + np.array([0.0, 0.9, 0.0]))
        self.server.initial_camera.look_at = (0.0, 0.0, 0.0)
        self.server.initial_camera.up = (0.0, 1.0, 0.0)
        scene.add_light_hemisphere("/light", sky_color=(255, 255, 255), ground_color=(150, 150, 150), intensity=1.2)
        links = {visual.leaf: (link, visual) for link in self.scene.robot.links for visual in link.visuals}
        for index, body in enumerate(self.scene.bodies):
            nodes: list[Any] = []
            self.nodes.append(nodes)
            self._arrows.append(self._arrow(index))
            if not body.leaves:
                continue
            vertices, faces = with_sharp_creases(join(*(self.scene.meshes[leaf] for leaf in body.leaves)))
            color = tuple(round(255 * each) for each in body.color)
            nodes.append(scene.add_mesh_simple(f"/colors/{index}", self._scale * vertices, faces, color=color, side="double"))
            link = links[body.leaves[0]][0]
            own = type(link)(link.name, link.origin, tuple(links[leaf][1] for leaf in body.leaves), (), link.inertial)
            looks = glb_bytes(
                Robot(self.scene.robot.name, (own,), (), self.scene.robot.diagonal, self.scene.robot.gltf_rotation)
            )
            nodes.append(scene.add_glb(f"/looks/{index}", looks, scale=self._scale, visible=False))

    def _arrow(self, index: int) -> Any:
        if not self._moves(index):
            return None
        points = self._scale * self.scene.axis_ends(index)[None]
        color = tuple(round(120 * each) for each in self.scene.bodies[index].color)
        size = {"shaft_radius": 0.012, "head_radius": 0.032, "head_length": 0.09}
        return self.server.scene.add_arrows(f"/axes/{index}", points, color, visible=self._has_axes, **size)

    def _place(self, node: Any, pose: NDArray[np.float64]) -> None:
        """Move a node that has scaled geometry."""
        node.wxyz = quaternion(pose[:3, :3])
        node.position = self._scale * pose[:3, 3] + self._offset


def _viser() -> ModuleType:
    try:
        import viser
    except ImportError:
        raise InputError("viser", "is not installed: pip install 'kinmo[view]'") from None
    return viser
