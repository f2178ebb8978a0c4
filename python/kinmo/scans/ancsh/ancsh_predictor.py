"""Asking the trained networks of ANCSH."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from kinmo.config import AncshConfig
from kinmo.core.errors import InputError
from kinmo.core.joint import JointKind
from kinmo.core.typed_tables import from_table
from kinmo.learning.weights import Weights, load_weights, pick_device
from kinmo.scans.ancsh.ancsh_network import KIND, AncshNetwork, LayoutAnswers, PartNetwork
from kinmo.scans.ancsh.ancsh_targets import REACH
from kinmo.scans.object_structure import Structure
from kinmo.scans.poses.category_prior import CategoryPrior
from kinmo.scans.poses.point_predictions import GlobalPredictions, PointPredictions
from kinmo.scans.poses.pose_fitting import PoseOptions, estimate_poses
from kinmo.scans.poses.scan_estimate import ScanEstimate
from kinmo.scans.preprocessing.input_frame import InputFrame, base_axes, initial_axes

F64 = NDArray[np.float64]

SCANS_AT_ONCE = 16
POINTS_TO_ASK_ABOUT = 1024


@dataclass(frozen=True, eq=False)
class Ancsh:
    """Both networks of one kind of object; the one called `npcs` has the say on parts."""

    joints: AncshNetwork
    parts: PartNetwork
    config: AncshConfig
    structure: Structure
    typical: CategoryPrior
    device: str

    @classmethod
    def load(cls, weights: Path, part_weights: Path, device: str = "auto") -> Ancsh:
        """Read what `train_ancsh` wrote. Raises InputError if it is not that, not whole, or the two do not go together."""
        device = pick_device(device)
        loaded = load_weights(weights, KIND)
        config, structure = _config_of(loaded), _structure_of(loaded)
        typical = _typical_of(loaded, structure)
        joints = AncshNetwork(config, structure.part_count, _classes_of(loaded, structure))
        loaded.fill(joints)
        own = load_weights(part_weights, KIND)
        if (_seen_as(_config_of(own)), _structure_of(own)) != (_seen_as(config), structure):
            raise InputError(part_weights, f"is for other objects than {weights}")
        parts = PartNetwork(_config_of(own), structure.part_count, _classes_of(own, structure))
        own.fill(parts)
        return cls(joints.to(device).eval(), parts.to(device).eval(), config, structure, typical, device)

    @property
    def points(self) -> int:
        """So many of a scan are to be seen; fewer do to train on, and too few tell no normals."""
        return max(self.config.points, POINTS_TO_ASK_ABOUT)

    def find(
        self, scans: Sequence[NDArray[np.floating]], diagonals: Sequence[float] | None = None, *, seed: int = 0
    ) -> tuple[list[PointPredictions], list[ScanEstimate]]:
        """What the networks say of scans, as in `answer`, and the parts and joints that follow."""
        answers = self.answer(scans, diagonals)
        options = PoseOptions(ties=self.config.ties, boxes=self.config.boxes, seed=seed)
        return answers, estimate_poses(answers, self.structure, options, self.typical)

    @torch.inference_mode()
    def answer(self, scans: Sequence[NDArray[np.floating]], diagonals: Sequence[float] | None = None) -> list[PointPredictions]:
        """What the networks say of scans [n, 3] in a camera's frame.

        `diagonals` are those of the objects, without which networks that were trained with `normalised = "object"` take the
        lengths of the scans for diagonals. All scans must have as many points.
        """
        sizes = np.ones(len(scans)) if diagonals is None else diagonals
        if not len(scans):
            return []
        points = np.stack(scans)
        rotations = initial_axes(points, self.config.axes)
        if self.config.axes == "base":
            said = np.concatenate([self._said_parts(seen) for seen, _ in self._batches(scans, sizes, rotations)])
            rotations = base_axes(points, said == 0, rotations)
        return [one for seen, frames in self._batches(scans, sizes, rotations) for one in self._answer(seen, frames)]

    def _batches(
        self, scans: Sequence[NDArray[np.floating]], diagonals: Sequence[float] | F64, rotations: F64
    ) -> Iterator[tuple[torch.Tensor, list[InputFrame]]]:
        """Points [B, n, 3] as the networks see them, and how they came to be so."""
        for start in range(0, len(scans), SCANS_AT_ONCE):
            some = slice(start, start + SCANS_AT_ONCE)
            each = list(zip(scans[some], diagonals[some], rotations[some], strict=True))
            frames = [InputFrame.of(points, self.config.normalised, size, axes) for points, size, axes in each]
            seen = np.stack([frame.apply(points) for frame, (points, _, _) in zip(frames, each, strict=True)])
            yield torch.from_numpy(seen).to(self.device), frames

    def _said_parts(self, seen: torch.Tensor) -> NDArray[np.int64]:
        """The part [B, n] of every point."""
        return np.asarray(self.parts(seen).parts.argmax(-1).cpu().numpy())

    def _answer(self, seen: torch.Tensor, frames: Sequence[InputFrame]) -> list[PointPredictions]:
        own, joints = self.joints.forward_all(seen)
        parts = self.parts(seen)
        naocs = joints.naocs(own.npcs)
        said = parts.parts.argmax(-1)
        home = own.parts.argmax(-1)
        arrays = [
            values.cpu().double().numpy()
            for values in (
                seen,
                _of_part(parts.npcs, said),
                _of_part(naocs, home) + joints.toward * ((1.0 - joints.heatmap) * REACH).unsqueeze(-1),
                joints.axes,
                own.npcs,
                naocs,
            )
        ]
        labels, homes, told = said.cpu().numpy(), home.cpu().numpy(), joints.joints.argmax(-1).cpu().numpy()
        labels = np.where(labels >= self.structure.part_count, -1, labels)
        layouts = [None] * len(frames) if joints.layout is None else _layouts(joints.layout)
        answers = []
        for row, frame in enumerate(frames):
            points, npcs, pivots, axes, own_npcs, own_naocs = (array[row] for array in arrays)
            scales, shifts = to_naocs(own_npcs, own_naocs, homes[row])
            answers.append(
                PointPredictions(frame, points, labels[row], npcs, scales, shifts, told[row], axes, pivots, layouts[row])
            )
        return answers


def _layouts(said: LayoutAnswers) -> list[GlobalPredictions]:
    half_sizes, pivots = (values.cpu().double().numpy() for values in (said.half_sizes, said.pivots))
    return [GlobalPredictions(*both) for both in zip(half_sizes, pivots, strict=True)]


def to_naocs(npcs: F64, naocs: F64, parts: NDArray[np.integer]) -> tuple[F64, F64]:
    """Scales [K] and shifts [K, 3] that take NPCS to NAOCS, both [n, K, 3], of the points on each of K `parts` [n].

    By their means and standard deviations, as the public code of ANCSH has it: what the heads of the network say one by one is
    right only together, since the shift of a point can make up for any scale. A part with fewer than two points takes all.
    """
    scales, shifts = np.empty(npcs.shape[1]), np.empty((npcs.shape[1], 3))
    for part in range(npcs.shape[1]):
        on_it = parts == part
        here, there = (places[on_it if on_it.sum() > 1 else slice(None), part] for places in (npcs, naocs))
        scales[part] = np.sqrt(there.var(axis=0).sum() / max(here.var(axis=0).sum(), 1e-12))
        shifts[part] = there.mean(axis=0) - scales[part] * here.mean(axis=0)
    return scales, shifts


def _seen_as(config: AncshConfig) -> tuple[str, str]:
    return config.normalised, config.axes


def _of_part(values: torch.Tensor, parts: torch.Tensor) -> torch.Tensor:
    """Values [B, n, 3] of [B, n, K, 3] at `parts` [B, n]."""
    index = parts.clamp(max=values.shape[2] - 1).view(*parts.shape, 1, 1).expand(-1, -1, 1, 3)
    return torch.gather(values, 2, index).squeeze(2)


def _config_of(loaded: Weights) -> AncshConfig:
    return from_table(AncshConfig, loaded.config, loaded.path.with_suffix(".json"), "config.")


def _structure_of(loaded: Weights) -> Structure:
    try:
        return Structure(tuple(JointKind(kind) for kind in loaded.facts["kinds"]), tuple(loaded.facts["parents"]))
    except (KeyError, TypeError, ValueError):
        raise InputError(loaded.path.with_suffix(".json"), "expected the joints of the objects it is for", "facts") from None


def _classes_of(loaded: Weights, structure: Structure) -> int:
    """Of points: the parts, and what is none of them where the network tells that."""
    classes, parts = loaded.facts.get("classes"), structure.part_count
    if not isinstance(classes, int) or classes not in (parts, parts + 1):
        raise InputError(loaded.path.with_suffix(".json"), f"expected {parts} or {parts + 1}, got {classes!r}", "facts.classes")
    return classes


def _typical_of(loaded: Weights, structure: Structure) -> CategoryPrior:
    try:
        return CategoryPrior.from_data(loaded.facts["typical"], structure)
    except (KeyError, TypeError, ValueError):
        problem = "expected what is typical of the objects it is for: run kinmo train ancsh again"
        raise InputError(loaded.path.with_suffix(".json"), problem, "facts.typical") from None
