"""Configuration of scans and of the networks that see them."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from typing import Annotated, Literal

from kinmo.config.bounds import Amount, Count, NonNegative, Positive, Share
from kinmo.config.training import TrainingConfig
from kinmo.core.typed_tables import Within


@dataclass(frozen=True)
class SensorConfig:
    """Depth camera. The default is an ideal one. Lengths are in diagonals of the object."""

    noise: Annotated[float, Within(0.0, 10.0)] = 0.0
    """Standard deviation of depths at a distance of 1. It grows with the square of the distance."""
    holes: Share = 0.0
    """Share of the pixels without depth, in patches."""
    steep: bool = False
    """No depth on surfaces at a steep angle."""
    crop: Share = 0.0
    """Largest share of the object that is cut off at one side."""
    floor: bool = False
    """A visible floor."""


@dataclass(frozen=True)
class ScansConfig:
    """Scanning of objects."""

    release: bool = False
    """Imitates the released code. All hinges go through -90 to 30 degrees in lockstep, cameras stand about the object at rest,
    and the canonical pose is that of the file."""
    states: Count = 31
    """Joint states of a training object."""
    views: Count = 30
    """Cameras per state of a training object."""
    variants: Count = 4
    """Forms of a training object: itself, mirrored and stretched. They share its states."""
    stretch: Annotated[float, Within(1.0, 10.0)] = 1.25
    """Largest stretch factor of a variant along an axis."""
    test_states: Count = 31
    """Joint states of a validation or test object."""
    test_views: Count = 6
    """Cameras per state of a validation or test object."""
    size: Annotated[int, Within(1, 16384)] = 512
    """Pixels per side of a depth image."""
    points: Annotated[int, Within(1, 1_000_000)] = 1024
    """Points of a frame."""
    least_pixels: NonNegative = 10
    """Least pixels of each part. Frames with fewer are skipped."""
    smallest_part: Share = 0.15
    """Diagonal below which a part belongs to its parent, in diagonals of the object."""
    joints: tuple[str, ...] = ()
    """Structure to learn, part by part, such as `R on 0`. Empty for that of most labelled objects."""
    renderer: Literal["raster", "pybullet"] = "raster"
    """Depth renderer: kinmo's own, or PyBullet's as in the paper (Python 3.10 and 3.11). The images agree."""
    sensor: SensorConfig = field(default_factory=SensorConfig)
    """The camera."""
    noisy_sensor: SensorConfig = SensorConfig(noise=0.003, holes=0.1, crop=0.3, steep=True)
    """The noisy camera of `kinmo table sensors`."""

    @property
    def closes_objects(self) -> bool:
        """True for the closed pose as canonical pose, False for that of the file."""
        return not self.release


@dataclass(frozen=True)
class AncshWeights:
    """Weights of ANCSH's losses."""

    parts: Amount = 1.0
    """Part of each point."""
    npcs: Amount = 10.0
    """Coordinates in the part (NPCS)."""
    naocs: Amount = 1.0
    """Coordinates in the object (NAOCS)."""
    joints: Amount = 1.0
    """Joint of each point."""
    heatmap: Amount = 5.0
    """Distance of each point to its joint."""
    toward: Amount = 5.0
    """Direction from each point to its joint."""
    axes: Amount = 0.2
    """Axis of each point's joint."""
    sizes: Amount = 0.5
    """Proportions of the parts' boxes. The released code has no such loss."""
    pivots: Amount = 2.0
    """Positions of the joints in the object. The released code has no such loss."""


AncshNetworkName = Literal["ancsh", "npcs"]
"""The network with all heads, and the one with parts and NPCS alone."""

MeanOver = Literal["parts", "points"]
"""Unit over which the losses of NPCS and NAOCS are means."""


@dataclass(frozen=True)
class AncshConfig:
    """ANCSH, the networks for scans (Li et al. 2020; paper, section 3.4)."""

    training: TrainingConfig
    """Training."""
    release: bool = False
    """Imitates the released code in input frames, heads, losses, sampling and pose fitting (docs/background/scans.md)."""
    weights: AncshWeights = field(default_factory=AncshWeights)
    """Weights of the losses."""
    points: Count = 1024
    """Points of a scan."""
    centers: Annotated[tuple[Count, ...], Within(2, 2)] = (512, 128)
    """PointNet++: centres of the two levels."""
    radii: Annotated[tuple[Positive, ...], Within(2, 2)] = (0.2, 0.4)
    """PointNet++: radii of the two levels."""
    neighbours: Annotated[tuple[Count, ...], Within(2, 2)] = (64, 64)
    """PointNet++: neighbours of a centre."""
    width: Annotated[float, Within(sys.float_info.min, 64.0)] = 1.0
    """PointNet++: width of the layers over the printed width."""
    dropout: Share = 0.5
    """Dropout in the heads."""
    batch_frames: Count = 16
    """Scans in a batch."""
    batches_per_epoch: Count = 100
    """Batches in an epoch."""
    validation_frames: Count = 4
    """Scans of each validation object."""
    confidence: Share = 0.8
    """Self-training: least share of each part's points that agree on its pose, in a scan that is labelled."""
    trusted: Share = 0.2
    """Least share of training scans with true labels; 0 for equal odds of all objects."""
    trusted_self_training: Share = 0.5
    """The same in self-training."""

    @property
    def norms(self) -> Literal["steady", "release"]:
        """Update of the batch norms' running statistics: a tenth per step, or half and less with every decay."""
        return "release" if self.release else "steady"

    @property
    def normalised(self) -> Literal["object", "scan"]:
        """Size that scans are divided by: the true diagonal of the object, or that of the visible points."""
        return "object" if self.release else "scan"

    @property
    def maps(self) -> bool:
        """True if NPCS are a linear map per part plus an offset per point."""
        return not self.release

    @property
    def global_head(self) -> bool:
        """True if the scan as a whole predicts box proportions and joint positions."""
        return not self.release

    @property
    def joint_labels(self) -> Literal["nearest", "release"]:
        """Joint of a point near two joints: the nearest, or the last one."""
        return "release" if self.release else "nearest"

    @property
    def mean_over(self) -> MeanOver:
        """Unit over which the losses of NPCS and NAOCS are means."""
        return "points" if self.release else "parts"

    @property
    def balance(self) -> float:
        """Exponent of sampling: points are drawn with odds (points of their part) ** -balance."""
        return 0.0 if self.release else 0.5

    @property
    def ties(self) -> Literal["tree", "pairs"]:
        """Joint constraints: over the whole tree with the category prior, or over pairs of parts."""
        return "pairs" if self.release else "tree"

    @property
    def boxes(self) -> Literal["fitted", "predicted"]:
        """Amodal boxes: with visible sides moved to the scan, or as predicted."""
        return "predicted" if self.release else "fitted"
