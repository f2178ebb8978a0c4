"""The shape of a robot file: its links are the parts, and its joints are the annotation."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from kinmo.core.categories import known_category
from kinmo.core.errors import InputError
from kinmo.core.frames import AXIS_VECTORS
from kinmo.core.mobility import Body, Mobility
from kinmo.core.shape import Mesh, Part, Shape, bounds_of, join
from kinmo.core.wording import clean_text, counted
from kinmo.io.readers.part_hierarchy import MAX_PARTS, has_surface
from kinmo.io.readers.partnet_annotation import META_FILE, UNKNOWN_CATEGORY, read_meta
from kinmo.io.readers.partnet_mobility_joints import around_rest, checked_against_bounds
from kinmo.io.readers.reader import SourceFiles
from kinmo.io.readers.robot_bodies import RobotBody, link_poses, robot_bodies
from kinmo.io.readers.robot_file import RobotFile
from kinmo.io.readers.scene import placed
from kinmo.io.readers.unlisted_meshes import unlisted_meshes

_USUAL_NAMES = ("mobility", "model", "robot", "object", "scene", "main")
"""File names that say nothing about the object. The name of the folder does."""


def robot_id(path: Path) -> str | None:
    """The id of the shape in a robot file: the name of the file, or of its folder if the file has a usual name."""
    name = path.stem if path.stem.lower() not in _USUAL_NAMES else path.absolute().parent.name
    return clean_text(name) or None


def robot_files(path: Path, named: Callable[[], Iterable[Path]]) -> SourceFiles:
    """The files that a robot is read from: `Reader.source_files`. `named` gives those that the file names."""
    folder = path.absolute().parent
    files = [path, folder / META_FILE]
    with suppress(InputError):  # of a broken file, which reading names
        files += named()
    return folder, list(dict.fromkeys(files))


def shape_of_robot(robot: RobotFile, layout: str, convention: str, problems: Iterable[InputError]) -> Shape:
    """The shape of a robot at rest, with z up and the front at -x, in metres.

    The links that have a surface are the parts, below one root. The mobility has the bodies that links with fixed joints form.
    It is None if nothing moves. The category comes from a file meta.json beside the robot, as in PartNet-Mobility, or from
    the robot's name if that is a known category.

    Args:
        robot: The robot.
        layout: Name of the format, as in `Shape.layout`.
        convention: Name of the format for people.
        problems: Meshes that could not be read.

    Raises:
        InputError: No link has a surface, or there are too many links.
    """
    problems = list(problems)
    repairs = [f"{Path(problem.where).name} skipped: {problem.problem}" for problem in problems]
    repairs += robot.repairs
    pieces = {name: [piece for piece in robot.pieces[name] if has_surface(piece.mesh)] for name in robot.links}
    for name, own in pieces.items():
        if flat := len(robot.pieces[name]) - len(own):
            what = f": {counted(flat, 'piece')} without a surface" if own else " has no surface"
            repairs.append(f"link {clean_text(name)}{what}: skipped")
    robot = replace(robot, pieces=pieces)
    poses = link_poses(robot)
    meshes = {
        name: join(*(placed(piece.mesh, poses[name], robot.path) for piece in own)) for name, own in pieces.items() if own
    }
    if not meshes:
        raise InputError(robot.path, "no link has geometry" + "".join(f" ({line})" for line in repairs[:1]))
    if len(meshes) > MAX_PARTS:
        raise InputError(robot.path, f"more than {MAX_PARTS} links with geometry")
    for folder in dict.fromkeys(file.parent for file in robot.mesh_files if file.suffix.lower() == ".obj"):
        repairs += unlisted_meshes(folder, {file.name for file in robot.mesh_files}, robot.path)
    order = _order(meshes)
    if len(order) == 1:
        repairs.append("one link has geometry, so no parts can be told apart: write one link per part")
    parts = [Part(0, robot.name, None, tuple(range(1, len(order) + 1)))]
    parts += [Part(place, clean_text(name), 0, (), meshes[name]) for place, name in enumerate(order, start=1)]
    place = {name: index for index, name in enumerate(order, start=1)}
    mobility = _mobility(robot_bodies(robot), place, bounds_of(meshes.values()), robot, repairs)
    category, annotation, source = _category(robot, repairs)
    guesses = {"up": f"up +z ({convention})", "metres_per_unit": f"1 unit = 1 m ({convention})"}
    return Shape(
        id=robot_id(robot.path) or "",
        category=category,
        parts=tuple(parts),
        source=robot.path,
        layout=layout,
        up=AXIS_VECTORS["z"],
        front=AXIS_VECTORS["-x"],
        mobility=mobility,
        partnet_id=annotation,
        repairs=tuple(repairs),
        guesses=guesses | ({} if source else {"category": f"category {category or 'unknown'}"}),
    )


def _order(meshes: dict[str, Mesh]) -> list[str]:
    """Names of the links by geometry, so that the order in the file does not matter: the largest area first, then by place."""
    low, high = bounds_of(meshes.values())
    size = float(np.linalg.norm(high - low))
    areas = {name: float(mesh.face_areas.sum()) for name, mesh in meshes.items()}
    total = sum(areas.values())

    def key(name: str) -> list[float]:
        mesh = meshes[name]
        middle = mesh.face_areas @ mesh.triangles.mean(axis=1) / areas[name]
        return [round(float(value), 5) for value in (-areas[name] / total, *((middle - low) / size))]

    return sorted(meshes, key=key)


def _mobility(
    found: tuple[RobotBody, ...],
    place: dict[str, int],
    bounds: tuple[np.ndarray, np.ndarray],
    robot: RobotFile,
    repairs: list[str],
) -> Mobility | None:
    """The bodies of a robot. None if no body has a joint."""
    bodies = []
    for index, body in enumerate(found):
        above = robot.joint_above.get(body.name)
        title = f"joint {clean_text(above.name) if above and above.name else f'of {clean_text(body.name)}'}"

        def note(repair: str, title: str = title) -> None:
            repairs.append(f"{title}: {repair}")

        joint = body.joint
        if joint is not None and joint.lower is not None and joint.upper is not None:
            lower, upper = around_rest(joint.lower, joint.upper, joint.kind, note)
            joint = replace(joint, lower=lower, upper=upper)
        if joint is not None:
            try:
                joint = checked_against_bounds(joint, lambda problem: InputError(robot.path, problem), *bounds, note)
            except InputError as problem:
                note(f"{problem.problem}: taken as fixed")
                joint = None
        elif body.moves:
            note(f"no hinge, slider or screw ({clean_text(above.type) if above else ''}): taken as fixed")
        if joint is not None and body.parent is None:
            note("there is no body to attach it to: taken as fixed")
            joint = None
        bodies.append(
            Body(index, clean_text(body.links[0]), tuple(sorted(place[name] for name in body.links)), body.parent, joint)
        )
    return Mobility(tuple(bodies)) if any(body.is_movable for body in bodies) else None


def _category(robot: RobotFile, repairs: list[str]) -> tuple[str, str | None, bool]:
    """The category, the PartNet annotation if there is one, and True if a file states the category."""
    folder = robot.path.absolute().parent
    if (folder / META_FILE).is_file():
        try:
            meta = read_meta(folder, "")
        except InputError as problem:
            repairs.append(f"{META_FILE} skipped: {problem.problem}")
        else:
            if meta.category != UNKNOWN_CATEGORY:
                return meta.category, meta.annotation, True
    return known_category(robot.name), None, False
