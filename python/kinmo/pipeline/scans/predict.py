"""Parts, joints and their states in a user's own depth scan."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from kinmo import __version__
from kinmo.categories import same_category
from kinmo.errors import InputError, did_you_mean
from kinmo.joint import JointKind
from kinmo.learning.ancsh.predict import Ancsh
from kinmo.pipeline.model_files import networks_digest
from kinmo.pipeline.scans.networks import Cell, trained_by_all_methods
from kinmo.pipeline.scans.pictures import view_of
from kinmo.pipeline.stage import Observer, Outcome, Plan
from kinmo.report.scan_picture import scan_picture
from kinmo.scans.articulated_object import Structure
from kinmo.scans.estimate import ScanEstimate
from kinmo.scans.scan_input import Intrinsics, check_is_scan, read_scan, write_points
from kinmo.wording import counted
from kinmo.workspace import DEFAULT_METHOD, Workspace, write_text_atomically

SCHEMA_VERSION = 1
PREFERRED = ("semi-weakly", "dsg-net", "semi", "supervised", "ceiling")
"""Settings whose networks answer, the first that there is."""
SECONDS = 5.0


@dataclass(frozen=True)
class PredictScan:
    """Find the parts of an object of `category` in a scan, by networks that saw pseudo labels of `method`, if it is given.

    Into `out` go all that was found (NAME.json), the part of every point (NAME.parts.npz), and a picture (NAME.svg).
    """

    source: Path
    out: Path
    workspace: Workspace
    category: str
    intrinsics: Intrinsics | None = None
    depth_scale: float | None = None
    method: str | None = None
    seed: int = 0
    device: str = "auto"

    def plan(self) -> Plan:
        place, cell = self._networks()
        check_is_scan(self.source)
        self._check_replaceable()
        return Plan((f"find the parts of a {cell.category} in {self.source} by the networks of {cell.title(place)}",), SECONDS)

    def run(self, observer: Observer) -> Outcome:
        place, cell = self._networks()
        self._check_replaceable()
        scan = read_scan(self.source, self.intrinsics, self.depth_scale)
        points = scan.points
        if scan.behind:
            count = scan.behind + len(points)
            observer.note(f"{scan.behind} of {count} points are left out: they are not before the camera (z > 0)")
        weights = cell.weights(place)
        assert weights is not None, "trained_cells has those with weights"
        network = Ancsh.load(*weights, device=self.device)
        rng = np.random.default_rng(self.seed)
        again = rng.integers(len(points), size=max(0, network.points - len(points)))
        seen = points[np.concatenate([rng.permutation(len(points))[: network.points], again])]
        if network.config.normalised == "object":
            observer.note("these networks want to know how large the whole object is; what is seen of it is taken for that")
        diagonal = float(np.linalg.norm(np.ptp(seen, axis=0)))
        (answer,), (found,) = network.find([seen], [diagonal], seed=self.seed)
        made_by = {"weights": networks_digest(weights), "trained": cell.title(place), "category": cell.category}
        parts = _of_nearest(points, seen, answer.parts)
        document = scan_document(found, parts, network.structure, self.source, made_by)
        picture = scan_picture([view_of(seen, answer.parts, found, network.structure)], self.source.stem)
        self.out.mkdir(parents=True, exist_ok=True)
        target, drawing, labelled = self._files()
        write_text_atomically(target, json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
        write_text_atomically(drawing, picture)
        write_points(labelled, points, parts=parts, places=scan.places)
        return Outcome(target, document, _text(document))

    def _files(self) -> tuple[Path, Path, Path]:
        """What is written."""
        name = self.source.stem
        return self.out / f"{name}.json", self.out / f"{name}.svg", self.out / f"{name}.parts.npz"

    def _check_replaceable(self) -> None:
        """Raises InputError if what is to be written would replace what kinmo has not found in the same scan."""
        document, *others = self._files()
        try:
            written = json.loads(document.read_text(encoding="utf-8"))
            is_own = "schema_version" in written and written["scan"] == _name_of(self.source)
        except (OSError, ValueError, KeyError, TypeError):
            is_own = False
        for path in (document, *others):
            if path.exists() and not is_own:
                raise InputError(
                    path, "is in the way, and not what kinmo predict found in this scan: name another folder by --out"
                )

    def _networks(self) -> tuple[Workspace, Cell]:
        """Raises InputError if nothing was trained for the category."""
        trained = trained_by_all_methods(self.workspace)
        if self.method is not None:
            trained = [(place, cell) for place, cell in trained if place.method == self.method]
        fitting = [(place, cell) for place, cell in trained if same_category(cell.category, self.category)]
        if not fitting:
            known = sorted({cell.category for _, cell in trained})
            near = did_you_mean(self.category, known)
            there = f"; there are those of {', '.join(known)}" if known else ""
            command = f"kinmo train all --category {quote(self.category)}" + (f" --method {self.method}" if self.method else "")
            problem = f"no networks that find a {self.category} in scans{near}{there}: run {command} first"
            raise InputError(self.workspace.models, problem)
        return min(fitting, key=self._rank)

    def _rank(self, trained: tuple[Workspace, Cell]) -> tuple[bool, int, int, bool]:
        """The least comes first."""
        place, cell = trained
        return cell.seed != self.seed, PREFERRED.index(cell.setting), cell.seed, place.method != DEFAULT_METHOD


def scan_document(
    found: ScanEstimate, of_points: NDArray[np.integer], structure: Structure, source: Path, made_by: Mapping[str, str]
) -> dict[str, Any]:
    """What was found, in the frame and the lengths of the scan (x to the right, y down, z forward); null where unknown.

    `of_points` [n] are the parts of the scan's points; `made_by` are facts about the networks.
    """
    parts = [
        {
            "id": part,
            "points": int((of_points == part).sum()),
            "inliers": _number(found.inliers[part]),
            "box": {
                "center": _list(found.centers[part]),
                "axes": _list(found.poses.rotations[part].T),
                "half_sizes": _list(found.half_extents[part]),
            },
            "pose": {
                "rotation": _list(found.poses.rotations[part]),
                "scale": _number(found.poses.scales[part]),
                "translation": _list(found.poses.translations[part]),
            },
        }
        for part in range(structure.part_count)
    ]
    joints = [
        {
            "part": row + 1,
            "parent": structure.parents[row],
            "kind": kind.value,
            "direction": _list(found.directions[row]),
            "pivot": None if kind is JointKind.PRISMATIC else _list(found.pivots[row]),
            "state": _number(found.states[row]),
            "turn": _number(found.turns[row]),
            "unit": "radians" if kind is JointKind.REVOLUTE else "lengths of the scan",
        }
        for row, kind in enumerate(structure.kinds)
    ]
    return {
        "schema_version": SCHEMA_VERSION,
        "kinmo": __version__,
        **made_by,
        "scan": _name_of(source),
        "parts": parts,
        "joints": joints,
    }


def _name_of(scan: Path) -> str:
    """The same for a file wherever one stands, and however it is spelled."""
    return str(scan.resolve())


def _of_nearest(points: NDArray[np.float64], seen: NDArray[np.float64], parts: NDArray[np.integer]) -> NDArray[np.int16]:
    """The part [n] of each of `points` [n, 3]: that of the nearest one that the networks have seen."""
    return np.asarray(parts[cKDTree(seen).query(points)[1]], np.int16)


def _text(document: dict[str, Any]) -> str:
    lines = [f"{document['category']}: {len(document['parts'])} parts"]
    for part in document["parts"]:
        agree = "not found" if part["inliers"] is None else f"{part['inliers']:.0%} of them agree on where it is"
        lines.append(f"  part {part['id']}: {counted(part['points'], 'point')}, {agree}")
    for joint in document["joints"]:
        state = joint["state"]
        shown = "not found"
        if state is not None:
            shown = f"{np.degrees(state):.1f}°" if joint["unit"] == "radians" else f"{state:.3f}"
        lines.append(f"  part {joint['part']} on part {joint['parent']}: {joint['kind']}, state {shown}")
    return "\n".join(lines)


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _list(values: NDArray[np.float64] | Sequence[float]) -> Any:
    array = np.asarray(values, np.float64)
    return array.tolist() if np.isfinite(array).all() else None
