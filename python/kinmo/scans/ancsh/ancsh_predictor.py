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
from kinmo.scans.ancsh.ancsh_network import KIND, AncshNetwork, PartNetwork, at_part
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
        prior: Prior of the category, from the objects that the networks were trained on.

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
        """Load the weights of the networks `ancsh` and `npcs` that `train_ancsh` wrote.

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
        """Point predictions for each scan, and the poses and joints that follow from them; arguments as in `predict_points`."""
        predictions = self.predict_points(scans, diagonals)
        options = PoseOptions(ties=self.config.ties, boxes=self.config.boxes, seed=seed)
        return predictions, estimate_poses(predictions, self.structure, options, self.prior)

    @torch.inference_mode()
    def predict_points(
        self, scans: Sequence[NDArray[np.floating]], diagonals: Sequence[float] | None = None
    ) -> list[PointPredictions]:
        """Predictions for each scan.

        Args:
            scans: Points [n, 3] of each scan in the camera frame. All scans have the same number of points.
            diagonals: Diagonal of each object, for networks with `release = true`; default 1.
        """
        sizes = np.ones(len(scans)) if diagonals is None else diagonals
        if not len(scans):
            return []
        points = np.stack(scans)
        if self.config.release:
            rotations = np.tile(np.eye(3), (len(points), 1, 1))
        else:
            rotations = manhattan_axes(points)
            labels = [self.parts(inputs).parts.argmax(-1).cpu().numpy() for inputs, _ in self._batches(scans, sizes, rotations)]
            rotations = base_axes(points, np.concatenate(labels) == 0, rotations)
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

    def _predict_batch(self, inputs: torch.Tensor, frames: Sequence[InputFrame]) -> list[PointPredictions]:
        """Predictions for a batch of inputs [B, n, 3], combined from both networks."""
        own, joints = self.joints.forward_all(inputs)
        parts = self.parts(inputs)
        naocs = joints.naocs(own.npcs)
        labels, own_labels = parts.parts.argmax(-1), own.parts.argmax(-1)
        pivots = at_part(naocs, own_labels) + joints.toward * ((1.0 - joints.heatmap) * JOINT_RADIUS).unsqueeze(-1)
        tensors = inputs, at_part(parts.npcs, labels), pivots, joints.axes, own.npcs, naocs
        arrays = [values.cpu().double().numpy() for values in tensors]
        chosen = (values.cpu().numpy() for values in (labels, own_labels, joints.joints.argmax(-1)))
        part_labels, home_labels, joint_labels = chosen
        part_labels = np.where(part_labels >= self.structure.part_count, -1, part_labels)
        wholes: list[GlobalPredictions | None] = [None] * len(frames)
        if joints.whole is not None:
            both = (values.cpu().double().numpy() for values in (joints.whole.half_sizes, joints.whole.pivots))
            wholes = [GlobalPredictions(*each) for each in zip(*both, strict=True)]
        predictions = []
        for row, frame in enumerate(frames):
            points, npcs, pivot, axes, own_npcs, own_naocs = (array[row] for array in arrays)
            scales, shifts = npcs_to_naocs(own_npcs, own_naocs, home_labels[row])
            on_points = points, part_labels[row], npcs, scales, shifts, joint_labels[row], axes, pivot
            predictions.append(PointPredictions(frame, *on_points, wholes[row]))
        return predictions


def npcs_to_naocs(npcs: F64, naocs: F64, parts: NDArray[np.integer]) -> tuple[F64, F64]:
    """Scale and shift of every part from NPCS to NAOCS, by means and standard deviations, as in the code of ANCSH.

    The predicted scale and shift of a single point are right only together, because a shift can make up for any scale. `npcs`
    and `naocs` [n, K, 3] are those of each point on each part. Scales [K] and shifts [K, 3] come from the points on a part
    [n], or from all points if there are fewer than two.
    """
    scales, shifts = np.empty(npcs.shape[1]), np.empty((npcs.shape[1], 3))
    for part in range(npcs.shape[1]):
        on_it = parts == part
        source, target = (points[on_it if on_it.sum() > 1 else slice(None), part] for points in (npcs, naocs))
        scales[part] = np.sqrt(target.var(axis=0).sum() / max(source.var(axis=0).sum(), 1e-12))
        shifts[part] = target.mean(axis=0) - scales[part] * source.mean(axis=0)
    return scales, shifts


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
