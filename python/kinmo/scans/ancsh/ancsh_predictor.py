"""Predictions of trained ANCSH networks for scans (Li et al. 2020; paper, section 3.4)."""

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
from kinmo.learning.weights import Weights, load_weights, pick_device
from kinmo.scans.ancsh.ancsh_network import KIND, AncshNetwork, GlobalOutput, PartNetwork
from kinmo.scans.ancsh.ancsh_targets import JOINT_RADIUS
from kinmo.scans.object_structure import Structure
from kinmo.scans.poses.category_prior import CategoryPrior
from kinmo.scans.poses.point_predictions import GlobalPredictions, PointPredictions
from kinmo.scans.poses.pose_fitting import PoseOptions, estimate_poses
from kinmo.scans.poses.scan_estimate import ScanEstimate
from kinmo.scans.preprocessing.input_frame import InputFrame, base_axes, manhattan_axes

F64 = NDArray[np.float64]

SCANS_AT_ONCE = 16
"""Number of scans in one batch, which bounds the memory."""
MIN_POINTS = 1024
"""Least number of points of a scan in prediction. Training needs fewer, but few points give no surface normals."""


@dataclass(frozen=True, eq=False)
class AncshPredictor:
    """Trained networks for objects of one structure.

    Attributes:
        joints: Network named `ancsh`, which predicts the joints.
        parts: Network named `npcs`, which decides on parts and NPCS.
        config: Configuration of the networks.
        structure: Structure of the objects.
        prior: Prior of the category, from the objects that the networks were trained on.
        device: Device to compute on.

    Example:
        >>> networks = AncshPredictor.load(Path("ancsh/weights.safetensors"), Path("npcs/weights.safetensors"))
        >>> predictions, estimates = networks.predict([points])
    """

    joints: AncshNetwork
    parts: PartNetwork
    config: AncshConfig
    structure: Structure
    prior: CategoryPrior
    device: str

    @classmethod
    def load(cls, weights: Path, part_weights: Path, device: str = "auto") -> AncshPredictor:
        """Load the weights that `train_ancsh` wrote.

        Args:
            weights: Weights of the network `ancsh`.
            part_weights: Weights of the network `npcs`.
            device: "cpu", "cuda", "mps", or "auto".

        Raises:
            InputError: A file does not hold such weights, is cut, or the two are for different objects or inputs.
        """
        device = pick_device(device)
        loaded = load_weights(weights, KIND)
        config, structure = loaded.typed_config(AncshConfig), _structure_of(loaded)
        prior = _prior_of(loaded, structure)
        joints = AncshNetwork(config, structure.part_count, _class_count(loaded, structure))
        loaded.fill(joints)
        own = load_weights(part_weights, KIND)
        if (own.typed_config(AncshConfig).release, _structure_of(own)) != (config.release, structure):
            raise InputError(part_weights, f"is for other objects than {weights}")
        parts = PartNetwork(own.typed_config(AncshConfig), structure.part_count, _class_count(own, structure))
        own.fill(parts)
        return cls(joints.to(device).eval(), parts.to(device).eval(), config, structure, prior, device)

    @property
    def points(self) -> int:
        """Number of points that a scan should have."""
        return max(self.config.points, MIN_POINTS)

    def predict(
        self, scans: Sequence[NDArray[np.floating]], diagonals: Sequence[float] | None = None, *, seed: int = 0
    ) -> tuple[list[PointPredictions], list[ScanEstimate]]:
        """Point predictions for scans, and the poses and joints that follow from them.

        Args:
            scans: As in `predict_points`.
            diagonals: As in `predict_points`.
            seed: Seed of RANSAC.

        Returns:
            Predictions and an estimate for each scan.
        """
        predictions = self.predict_points(scans, diagonals)
        options = PoseOptions(ties=self.config.ties, boxes=self.config.boxes, seed=seed)
        return predictions, estimate_poses(predictions, self.structure, options, self.prior)

    @torch.inference_mode()
    def predict_points(
        self, scans: Sequence[NDArray[np.floating]], diagonals: Sequence[float] | None = None
    ) -> list[PointPredictions]:
        """Predictions of the networks for the points of scans.

        Args:
            scans: Points [n, 3] of each scan in the camera frame. All scans have the same number of points.
            diagonals: Diagonal of each object, for networks with `release = true`; default 1.

        Returns:
            Predictions for each scan.
        """
        sizes = np.ones(len(scans)) if diagonals is None else diagonals
        if not len(scans):
            return []
        points = np.stack(scans)
        if self.config.release:
            rotations = np.tile(np.eye(3), (len(points), 1, 1))
        else:
            rotations = manhattan_axes(points)
            parts = np.concatenate([self._most_likely_parts(inputs) for inputs, _ in self._batches(scans, sizes, rotations)])
            rotations = base_axes(points, parts == 0, rotations)
        batches = self._batches(scans, sizes, rotations)
        return [prediction for inputs, frames in batches for prediction in self._predict_batch(inputs, frames)]

    def _batches(
        self, scans: Sequence[NDArray[np.floating]], diagonals: Sequence[float] | F64, rotations: F64
    ) -> Iterator[tuple[torch.Tensor, list[InputFrame]]]:
        """Points [B, n, 3] in the input frame, and the frame of each scan."""
        for start in range(0, len(scans), SCANS_AT_ONCE):
            some = slice(start, start + SCANS_AT_ONCE)
            each = list(zip(scans[some], diagonals[some], rotations[some], strict=True))
            frames = [InputFrame.of(points, self.config.normalised, size, axes) for points, size, axes in each]
            inputs = np.stack([frame.apply(points) for frame, (points, _, _) in zip(frames, each, strict=True)])
            yield torch.from_numpy(inputs).to(self.device), frames

    def _most_likely_parts(self, inputs: torch.Tensor) -> NDArray[np.int64]:
        """Most likely part [B, n] of every point."""
        return np.asarray(self.parts(inputs).parts.argmax(-1).cpu().numpy())

    def _predict_batch(self, inputs: torch.Tensor, frames: Sequence[InputFrame]) -> list[PointPredictions]:
        """Predictions for a batch of inputs [B, n, 3], combined from both networks."""
        own, joints = self.joints.forward_all(inputs)
        parts = self.parts(inputs)
        naocs = joints.naocs(own.npcs)
        labels = parts.parts.argmax(-1)
        own_labels = own.parts.argmax(-1)
        pivots = _at_part(naocs, own_labels) + joints.toward * ((1.0 - joints.heatmap) * JOINT_RADIUS).unsqueeze(-1)
        arrays = [
            values.cpu().double().numpy()
            for values in (inputs, _at_part(parts.npcs, labels), pivots, joints.axes, own.npcs, naocs)
        ]
        part_labels, home_labels, joint_labels = (
            values.cpu().numpy() for values in (labels, own_labels, joints.joints.argmax(-1))
        )
        part_labels = np.where(part_labels >= self.structure.part_count, -1, part_labels)
        wholes = [None] * len(frames) if joints.whole is None else _global_predictions(joints.whole)
        predictions = []
        for row, frame in enumerate(frames):
            points, npcs, pivot, axes, own_npcs, own_naocs = (array[row] for array in arrays)
            scales, shifts = npcs_to_naocs(own_npcs, own_naocs, home_labels[row])
            predictions.append(
                PointPredictions(
                    frame, points, part_labels[row], npcs, scales, shifts, joint_labels[row], axes, pivot, wholes[row]
                )
            )
        return predictions


def _global_predictions(output: GlobalOutput) -> list[GlobalPredictions]:
    half_sizes, pivots = (values.cpu().double().numpy() for values in (output.half_sizes, output.pivots))
    return [GlobalPredictions(*both) for both in zip(half_sizes, pivots, strict=True)]


def npcs_to_naocs(npcs: F64, naocs: F64, parts: NDArray[np.integer]) -> tuple[F64, F64]:
    """Scale and shift of every part from NPCS to NAOCS, by means and standard deviations, as in the code of ANCSH.

    The predicted scale and shift of a single point are right only together, because a shift can make up for any scale.

    Args:
        npcs: NPCS [n, K, 3] of each point on each part.
        naocs: NAOCS [n, K, 3] of each point on each part.
        parts: Part of each point [n]. A part with fewer than two points uses all points.

    Returns:
        Scales [K] and shifts [K, 3].
    """
    scales, shifts = np.empty(npcs.shape[1]), np.empty((npcs.shape[1], 3))
    for part in range(npcs.shape[1]):
        on_it = parts == part
        source, target = (points[on_it if on_it.sum() > 1 else slice(None), part] for points in (npcs, naocs))
        scales[part] = np.sqrt(target.var(axis=0).sum() / max(source.var(axis=0).sum(), 1e-12))
        shifts[part] = target.mean(axis=0) - scales[part] * source.mean(axis=0)
    return scales, shifts


def _at_part(values: torch.Tensor, parts: torch.Tensor) -> torch.Tensor:
    """Values [B, n, 3] out of [B, n, K, 3], at `parts` [B, n]."""
    index = parts.clamp(max=values.shape[2] - 1).view(*parts.shape, 1, 1).expand(-1, -1, 1, 3)
    return torch.gather(values, 2, index).squeeze(2)


def _structure_of(loaded: Weights) -> Structure:
    try:
        return Structure(tuple(JointKind(kind) for kind in loaded.facts["kinds"]), tuple(loaded.facts["parents"]))
    except (KeyError, TypeError, ValueError):
        raise InputError(loaded.path.with_suffix(".json"), "expected the joints of the objects it is for", "facts") from None


def _class_count(loaded: Weights, structure: Structure) -> int:
    """Number of classes of points: the parts, and "no part" if the network knows it."""
    classes, parts = loaded.facts.get("classes"), structure.part_count
    if not isinstance(classes, int) or classes not in (parts, parts + 1):
        raise InputError(loaded.path.with_suffix(".json"), f"expected {parts} or {parts + 1}, got {classes!r}", "facts.classes")
    return classes


def _prior_of(loaded: Weights, structure: Structure) -> CategoryPrior:
    try:
        return CategoryPrior.from_data(loaded.facts["category_prior"], structure)
    except (KeyError, TypeError, ValueError):
        problem = "expected the prior of the category: run kinmo train ancsh again"
        raise InputError(loaded.path.with_suffix(".json"), problem, "facts.category_prior") from None
