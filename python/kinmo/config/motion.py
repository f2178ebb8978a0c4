"""Configuration of the networks for shapes: motion GNN, axis selection, ranking, refinement."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Literal

from kinmo.config.bounds import Amount, Count, Counts, NonNegative, Offset, Positive, Share
from kinmo.config.training import TrainingConfig
from kinmo.core.typed_tables import Within


@dataclass(frozen=True)
class PointEncoderConfig:
    """Point-cloud encoder."""

    kind: Literal["pointnet", "dgcnn"]
    """Architecture: shared layers and a maximum over the points, or EdgeConv layers."""
    points: Count
    """Number of points of a cloud."""
    widths: Counts
    """Width of each layer."""
    features: NonNegative = 0
    """Number of output features; 0 for the pooled ones of DGCNN."""
    neighbours: Count = 20
    """DGCNN: neighbours of each point."""
    embedding: NonNegative = 0
    """DGCNN: width after the concatenation of all layers."""
    head: tuple[Count, ...] = ()
    """DGCNN: widths of the layers after pooling."""
    norm: Literal["batch", "group", "none"] = "batch"
    """Normalisation of the layers."""
    dropout: Share = 0.0
    """Dropout in the head."""
    static: bool = False
    """DGCNN: neighbours found once, by position, instead of by the features of each layer."""
    factored: bool = False
    """DGCNN: EdgeConv as the faster A x_j + C x_i, with normalisation after the maximum."""


@dataclass(frozen=True)
class GnnConfig:
    """Motion GNN (paper, section 3.2)."""

    leaf: PointEncoderConfig
    """Encoder of the leaves' points."""
    training: TrainingConfig
    """Training."""
    edges: Literal["siblings", "contact"] = "siblings"
    """Edges between all siblings, or between siblings in contact."""
    contact: Amount = 0.01
    """Largest distance of parts in contact, in diagonals."""
    inner_boxes: bool = True
    """Boxes of inner nodes as input. The paper has none."""
    box_features: Count = 100
    """Width of a box's features."""
    node_features: Count = 256
    """Width of a node's features."""
    child_rounds: NonNegative = 2
    """Message-passing rounds between the children of a node, in the hierarchy encoder."""
    relation_features: Count = 128
    """Width of the relation of two boxes."""
    name_features: Count = 128
    """Width of a name's features."""
    name_buckets: Count = 2048
    """Number of buckets for hashed words of names."""
    hide_names: Share = 0.25
    """Share of training shapes whose names are hidden."""
    graph_hidden: Count = 512
    """Width of the message layers."""
    graph_features: Count = 128
    """Width of a node in the graph."""
    graph_rounds: Count = 5
    """Message-passing rounds in the graph."""
    head_features: Count = 128
    """Width of the edge heads."""
    class_balance: Amount = 0.0
    """Exponent of the class weights in the type loss: share ** -class_balance. 0 for equal weights, as in the paper."""
    variants: NonNegative = 0
    """Further forms of each training shape: mirrored, and stretched along its axes."""
    stretch: Amount = 0.0
    """Largest stretch of a variant: factors up to e ** +-stretch."""
    batch_shapes: Count = 2
    """Shapes in a batch."""
    batch_edges: Count = 20000
    """Edges in a batch at most."""


@dataclass(frozen=True)
class AxisConfig:
    """Axis-selection network (paper, section 3.3)."""

    encoder: PointEncoderConfig
    """Encoder of both clouds."""
    training: TrainingConfig
    """Training."""
    head: tuple[Count, ...] = (256, 128)
    """Widths of the layers that compare the clouds."""
    head_dropout: Share = 0.5
    """Dropout in the head."""
    articulated: Share = 0.5
    """Share of training pairs whose original cloud is first moved along the true joint."""
    focus: bool = False
    """Clouds that are denser near the part, centred on it, and scaled by its size."""
    turned: bool = False
    """Random rotations and mirroring of training clouds that map axes to axes."""
    near_angle: Amount = 5.0
    """Angle to the true axis below which an axis is no negative example, in degrees (with `near_distance`)."""
    near_distance: Amount = 0.05
    """Distance to the true axis below which an axis is no negative example, in diagonals (with `near_angle`)."""
    same_motion: Amount = 0.015
    """Motion difference below which an axis is no negative example, in diagonals."""
    name_balance: Share = 1.0
    """Exponent of sampling by name: a joint is drawn with odds (number of joints of its name) ** -name_balance."""
    batch_joints: Count = 8
    """Joints in a batch. Each gives a positive and a negative pair."""
    batches_per_epoch: NonNegative = 0
    """Batches in an epoch; 0 for one pass over all joints."""


@dataclass(frozen=True)
class GroupingConfig:
    """Grouping networks of kinmo's own method."""

    training: TrainingConfig
    """Training."""
    continued: TrainingConfig = field(
        default_factory=lambda: TrainingConfig(4, 5e-4, weight_decay=1e-2, decay_epochs=0, average=0.99, keep="last", threads=1)
    )
    """Continued training from trained weights (`--from`)."""
    members: Count = 3
    """Number of networks whose logits are averaged."""
    width: Count = 96
    """Width of the states of leaves and pairs."""
    rounds: Count = 4
    """Message-passing rounds."""
    word_features: Count = 32
    """Width of a word's features."""
    dropout: Share = 0.1
    """Dropout."""
    hide_names: Share = 0.45
    """Share of training shapes whose names are hidden."""
    hide_leaf_names: Share = 0.1
    """Share of the other leaves whose names are hidden."""
    hide_words: Share = 0.2
    """Share of training shapes whose names are in an unknown language: only how alike they are is seen."""
    hide_hierarchy: Share = 0.6
    """Share of training shapes whose hierarchy is hidden."""
    batch_graphs: Count = 24
    """Shapes in a batch."""


@dataclass(frozen=True)
class ContinuedConfig:
    """Continued training of the ranking networks on few shapes, from weights trained on many."""

    training: TrainingConfig = field(
        default_factory=lambda: TrainingConfig(14, 7e-4, weight_decay=1e-2, decay_epochs=0, average=0.99, keep="last")
    )
    """Training."""
    batch_views: Count = 8
    """Views in a batch."""
    initial_share: Share = 0.5
    """Share of the initial weights in the result. A mean of old and new weights does best on validation shapes."""


@dataclass(frozen=True)
class RankingConfig:
    """Ranking networks of kinmo's own method."""

    training: TrainingConfig
    """Training."""
    continued: ContinuedConfig = field(default_factory=ContinuedConfig)
    """Continued training from trained weights (`--from`)."""
    members: Count = 3
    """Number of networks whose probabilities are averaged."""
    width: Count = 128
    """Width of the layers."""
    word_features: Count = 32
    """Width of a word's features."""
    dropout: Share = 0.1
    """Dropout."""
    hide_names: Share = 0.3
    """Share of training shapes whose names are hidden."""
    hide_group_names: Share = 0.1
    """Share of the other parts whose names are hidden."""
    hide_categories: Share = 0.6
    """Share of training shapes whose category is hidden; 1 for networks that never see it, for unseen categories."""
    batch_views: Count = 16
    """Views in a batch."""
    score_slope: Positive = 1.0
    """Factor on the logit of a joint's score. Below 1, scores are less extreme than the networks' probabilities."""
    score_offset: Offset = 0.0
    """Added to the logit of a joint's score after the factor."""

    @property
    def sees_categories(self) -> bool:
        """True if the networks see categories."""
        return self.hide_categories < 1.0


@dataclass(frozen=True)
class LimitsConfig:
    """Limits network of kinmo's own method."""

    training: TrainingConfig = field(
        default_factory=lambda: TrainingConfig(40, 2e-3, weight_decay=1e-2, decay_epochs=0, average=0.99, threads=1)
    )
    """Training."""
    continued: TrainingConfig = field(
        default_factory=lambda: TrainingConfig(
            10, 5e-4, weight_decay=1e-2, decay_epochs=0, average=0.99, keep="last", threads=1
        )
    )
    """Continued training from trained weights (`--from`)."""
    width: Count = 96
    """Width of the layers."""
    word_features: Count = 16
    """Width of a word's features."""
    dropout: Share = 0.2
    """Dropout."""
    hide_names: Share = 0.4
    """Share of training joints whose names are hidden."""
    batch_joints: Count = 64
    """Joints in a batch."""


@dataclass(frozen=True)
class RefinementConfig:
    """Joints from edge predictions (paper, section 3.3), and the acceptance of pseudo labels (section 3.4)."""

    weights: Annotated[tuple[Amount, ...], Within(3, 4)] = (0.5, 0.3, 0.2, 0.0)
    """Weights of feasibility, direction, position, and free range in the paper's score (equation 7)."""
    position: Literal["line", "printed"] = "line"
    """Position similarity: 1 - distance to the candidate's line, or as printed (equation 6)."""
    threshold: Share = 0.6
    """Least score of a pseudo label of the paper's method (tau)."""
    chance: Share = 0.3
    """Least score of a pseudo label of kinmo's method, a probability."""
    doubt: Share = 0.05
    """Largest probability of motion of a fixed part in a pseudo label of kinmo's method."""
    extra: tuple[Literal["boxes", "contact", "symmetry"], ...] = ()
    """Candidates beyond the paper's."""
    contact_pivots: Literal["central", "revolute", "none"] = "central"
    """Axes with a second pivot, in the interaction region."""

    def least_score(self, method: str) -> float:
        """Score that every joint of a pseudo label by `method` must exceed."""
        return self.threshold if method == "paper" else self.chance

    @property
    def sweeps(self) -> bool:
        """True if the free range counts in the paper's score."""
        return any(weight > 0 for weight in self.weights[3:])
