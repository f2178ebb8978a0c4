"""Typed configurations, read from TOML.

A configuration is a tree of frozen dataclasses. `paper` holds the sizes of the paper and its release, `small` those that
train on two CPU cores; a user's own file has the same keys, or `extends` one of these by name and has those that differ.
Unknown keys and wrong types end in an InputError that names file and key (`kinmo.core.typed_tables`).
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Literal

from kinmo.core.errors import InputError, did_you_mean
from kinmo.core.typed_tables import Within, from_table

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

EXTENDS = "extends"
"""The key of a file that goes on from a configuration that comes with kinmo."""

MANY = 10**9
"""More than there is ever a use for, and few enough for whatever counts with them."""
Count = Annotated[int, Within(1, MANY)]
Number = Annotated[int, Within(0, MANY)]
Positive = Annotated[float, Within(sys.float_info.min, sys.float_info.max)]
Amount = Annotated[float, Within(0.0, sys.float_info.max)]
Share = Annotated[float, Within(0.0, 1.0)]
Counts = Annotated[tuple[Count, ...], Within(1)]
Precision = Literal["32-true", "bf16-mixed", "16-mixed"]
"""Numbers that layers compute in: float32, or mixed with bfloat16 or float16."""


@dataclass(frozen=True)
class TrainingConfig:
    """Adam; `decay` multiplies the learning rate every `decay_epochs` epochs (0: the rate falls to zero along a cosine).

    `average` is the decay a step of a moving average of the weights, which then is what is chosen and kept (0: no average).
    `keep`: the epoch that did best on validation, or the last one, where the shapes to choose by are too few to tell.
    `threads` of the CPU (0: PyTorch's choice): small networks are faster on one, and come out the same on every machine.
    """

    epochs: Count
    learning_rate: Annotated[float, Within(sys.float_info.min, 1e3)]
    weight_decay: Amount = 1e-4
    decay: Positive = 0.7
    decay_epochs: Number = 20
    gradient_clip: Amount = 1.0
    average: Share = 0.0
    keep: Literal["best", "last"] = "best"
    precision: Precision = "32-true"
    threads: Annotated[int, Within(0, 1024)] = 0


@dataclass(frozen=True)
class PointEncoderConfig:
    """A point-cloud encoder.

    `pointnet`: shared layers of `widths`, a maximum over the points, one linear layer to `features`. `dgcnn`: EdgeConv layers
    of `widths` on `neighbours` neighbours, concatenated to `embedding`, maximum and mean, then layers of `head` to `features`
    (0: the pooled 2 x `embedding` features are the result). `static` finds neighbours once, by place; `factored` splits an
    EdgeConv into A x_j + C x_i and normalises after the maximum.
    """

    kind: Literal["pointnet", "dgcnn"]
    points: Count
    widths: Counts
    features: Number = 0
    neighbours: Count = 20
    embedding: Number = 0
    head: tuple[Count, ...] = ()
    norm: Literal["batch", "group", "none"] = "batch"
    dropout: Share = 0.0
    static: bool = False
    factored: bool = False


@dataclass(frozen=True)
class GnnConfig:
    """The motion GNN (paper, section 3.2).

    `inputs`: `paper` has points, boxes, names and the relation of two boxes; `kinmo` adds their relative pose, distance and
    contact to every edge. `edges`: all sibling pairs, or those in contact (closer than `contact` diagonals). `direction_loss`:
    the mean over motion edges of the un-squared L2 norm, one Frobenius norm over all of them, or the mean with the sign of the
    axis left open. `class_weights`: one for each of the ten types, or none for ones; `class_balance` multiplies them with
    (share of the class) ** -class_balance. `variants`: how many more forms of a training shape are shown, mirrored and
    stretched along its axes by up to e ** +-`stretch`.
    """

    leaf: PointEncoderConfig
    training: TrainingConfig
    inputs: Literal["paper", "kinmo"] = "kinmo"
    edges: Literal["siblings", "contact"] = "siblings"
    contact: Amount = 0.01
    inner_boxes: bool = True
    box_features: Count = 100
    node_features: Count = 256
    child_rounds: Number = 2
    relation_features: Count = 128
    name_features: Count = 128
    name_buckets: Count = 2048
    hide_names: Share = 0.25
    graph_hidden: Count = 512
    graph_features: Count = 128
    graph_rounds: Count = 5
    head_features: Count = 128
    direction_loss: Literal["mean", "frobenius", "undirected"] = "mean"
    class_weights: tuple[Amount, ...] = ()
    class_balance: Amount = 0.0
    variants: Number = 0
    stretch: Amount = 0.0
    batch_shapes: Count = 2
    batch_edges: Count = 20000
    per_category: bool = False


@dataclass(frozen=True)
class AxisConfig:
    """The axis-selection network (paper, section 3.3).

    `articulated`: share of training pairs whose original cloud is itself moved along the true joint. A negative within
    `near_angle` degrees and `near_distance` diagonals of the truth is none, nor is one that moves the part to within
    `same_motion` diagonals of where the truth does. `negatives`: `edges` of the movable part's box as printed, or those and the
    centre lines too. `focus`: clouds are denser near the part, and seen from its middle in units of its size; `turned`: in
    training they are turned and mirrored at random so that axes stay axes. A joint is drawn with odds of (how many joints have
    its name) ** -`name_balance`. A batch holds `batch_joints` joints, a positive and a negative pair each.
    """

    encoder: PointEncoderConfig
    training: TrainingConfig
    head: tuple[Count, ...] = (256, 128)
    head_dropout: Share = 0.5
    articulated: Share = 0.5
    negatives: Literal["edges", "lines"] = "lines"
    focus: bool = False
    turned: bool = False
    near_angle: Amount = 5.0
    near_distance: Amount = 0.05
    same_motion: Amount = 0.015
    name_balance: Share = 1.0
    batch_joints: Count = 8
    batches_per_epoch: Number = 0


@dataclass(frozen=True)
class ContinuedConfig:
    """How ranking networks trained on many shapes, say procedural ones, go on with a few others, say real ones.

    Of the weights that they started from, `initial_share` stays in the result: networks half-way keep what they knew of the
    many shapes, and did better on validation shapes of the few than those at either end.
    """

    training: TrainingConfig = TrainingConfig(
        epochs=14, learning_rate=7e-4, weight_decay=1e-2, decay_epochs=0, average=0.99, keep="last"
    )
    batch_views: Count = 8
    initial_share: Share = 0.5


@dataclass(frozen=True)
class RankingConfig:
    """The ranking networks of the `kinmo` method.

    `members` networks are trained side by side, and the mean of their probabilities decides. `hide_names` is the share of
    shapes whose names are hidden in training, `hide_unit_names` that of parts besides, `hide_categories` that of shapes whose
    category is hidden (all: the networks never look at it, for shapes of categories that were not trained on). A shape gives
    two views, its bodies and its nodes; `batch_views` make a batch. `continued` is for training that starts from trained
    weights.
    """

    training: TrainingConfig
    continued: ContinuedConfig = field(default_factory=ContinuedConfig)
    members: Count = 3
    width: Count = 128
    word_features: Count = 32
    dropout: Share = 0.1
    hide_names: Share = 0.3
    hide_unit_names: Share = 0.1
    hide_categories: Share = 0.0
    batch_views: Count = 16

    @property
    def sees_categories(self) -> bool:
        """Whether the networks are ever shown a category."""
        return self.hide_categories < 1.0


@dataclass(frozen=True)
class SensorConfig:
    """A depth camera; lengths are diagonals of the object. The default sees everything as it is.

    `noise` is the standard deviation of depths at a distance of one, and grows with the square of the distance, as that of
    cameras that triangulate. `holes` is the share of the pixels that see nothing, in patches; with `steep`, surfaces seen under
    a sharp angle are not seen either. `crop` is the largest share of the object's part of the picture that is cut away, to one
    side. With `floor`, a plane below the object is seen too.
    """

    noise: Annotated[float, Within(0.0, 10.0)] = 0.0
    holes: Share = 0.0
    steep: bool = False
    crop: Share = 0.0
    floor: bool = False


@dataclass(frozen=True)
class ScansConfig:
    """How objects are scanned.

    An object to train on is seen in `states` of its joints, from `views` cameras each; one to choose or test by in
    `test_states` and from `test_views`. The states are shared out among `variants` of an object to train on: itself, and
    others like it (`object_variants`), up to `stretch` times as long or as short in each direction; only objects that are
    `closed` have such. `sampling`: every joint has a value of its own out of its range, or all go through theirs in
    `lockstep`, or as in the `release` all through the same angles. `cameras` stand about the object as it is in each `state`,
    or as in the release about what it is at `rest`. Pictures have `size` pixels a side, frames `points` points;
    a frame in which a part has fewer than `least_pixels` is refused. A part smaller than `smallest_part` diagonals goes with
    what it moves against. Networks learn objects with the `joints` that are named, part by part as tables do (`R on 0`), or if
    none are, with those that most labelled ones have. They learn the `canonical` state of objects: `closed` (`closed_pose`),
    or whatever their `file` shows. `noisy_sensor` takes `sensor`'s place to tell what a bad sensor costs. `pybullet`
    is the paper's renderer.
    """

    states: Count = 31
    views: Count = 30
    variants: Count = 4
    stretch: Annotated[float, Within(1.0, 10.0)] = 1.25
    test_states: Count = 31
    test_views: Count = 6
    sampling: Literal["independent", "lockstep", "release"] = "independent"
    cameras: Literal["state", "rest"] = "state"
    size: Annotated[int, Within(1, 16384)] = 512
    points: Annotated[int, Within(1, 1_000_000)] = 1024
    least_pixels: Number = 10
    smallest_part: Share = 0.15
    joints: tuple[str, ...] = ()
    canonical: Literal["closed", "file"] = "closed"
    renderer: Literal["raster", "pybullet"] = "raster"
    sensor: SensorConfig = field(default_factory=SensorConfig)
    noisy_sensor: SensorConfig = SensorConfig(noise=0.003, holes=0.1, crop=0.3, steep=True)


@dataclass(frozen=True)
class AncshWeights:
    """Weights of the losses of ANCSH; the defaults are those of its release, which has not the last two."""

    parts: Amount = 1.0
    npcs: Amount = 10.0
    naocs: Amount = 1.0
    joints: Amount = 1.0
    heatmap: Amount = 5.0
    toward: Amount = 5.0
    axes: Amount = 0.2
    sizes: Amount = 0.5
    pivots: Amount = 2.0


AncshNetworkName = Literal["ancsh", "npcs"]
"""The one with all heads, and that with those of parts and NPCS alone."""

MeanOver = Literal["parts", "points"]
"""What losses of NPCS and NAOCS are means over (`AncshConfig.mean_over`)."""


@dataclass(frozen=True)
class AncshConfig:
    """The networks of ANCSH (the paper, section 3.4; Li 2020).

    `centers`, `radii` and `neighbours` of the two levels of PointNet++, and the `width` of its layers over the printed ones;
    features are interpolated with weights 1 / distance ** `distance_power`. `norms`: running statistics of batch norms move by
    a tenth a step, or as in the `release` by half, and half as much whenever the rate falls. `normalised`: scans are brought to
    the true size of the whole `object`, as in the release, or to that of the visible `scan`, which is all that a user has.
    `axes`: they are seen along those of the `camera`, as in the release, along those that most surfaces face (`manhattan`), or
    twice, the second time along those that the surfaces of the `base` face. `maps`: NPCS of a part are a linear map of the
    points, told of the scan as a whole, and what every point adds; or as in the release what every point says alone.
    `global_head`: of the scan as a whole is asked what is the same for all points, the proportions of the parts' boxes and the
    places of the joints' axes, which in the release follow from what every point says.
    `joint_labels`: a point near to two joints tells of the `nearest`, or as in the `release` of the last, where joints
    without a place have one too. `mean_over`: losses of NPCS and NAOCS are means over the `parts` that scans show, however few
    points each, or as in the release over all `points`. An
    epoch has `batches_per_epoch` batches of `batch_frames` scans of `points` points, drawn with odds that fall with the number
    of points of a part to the power `balance`; validation sees `validation_frames` an object. `ties`: predicted joints tie the
    poses of all parts of the `tree` together, and what is typical of the objects trained on narrows these down; or as in the
    release joints tie two parts at a time (`pairs`), or `none`. `boxes` of parts are as `predicted`, or `fitted` to the
    sides that the scan shows. What networks say of a scan is a label for others where of every part at least the share
    `confidence` of its points agrees on where that is. Objects with true labels have the share `trusted` of all scans that are drawn at least (0:
    all objects have equal odds), or `trusted_in_semi` beside those that networks labelled.
    """

    training: TrainingConfig
    weights: AncshWeights = field(default_factory=AncshWeights)
    points: Count = 1024
    centers: Annotated[tuple[Count, ...], Within(2, 2)] = (512, 128)
    radii: Annotated[tuple[Positive, ...], Within(2, 2)] = (0.2, 0.4)
    neighbours: Annotated[tuple[Count, ...], Within(2, 2)] = (64, 64)
    width: Annotated[float, Within(sys.float_info.min, 64.0)] = 1.0
    distance_power: Annotated[int, Within(1, 2)] = 2
    dropout: Share = 0.5
    norms: Literal["steady", "release"] = "steady"
    normalised: Literal["object", "scan"] = "scan"
    axes: Literal["camera", "manhattan", "base"] = "base"
    maps: bool = True
    global_head: bool = True
    joint_labels: Literal["nearest", "release"] = "nearest"
    mean_over: MeanOver = "parts"
    batch_frames: Count = 16
    batches_per_epoch: Count = 100
    balance: Share = 0.5
    validation_frames: Count = 4
    ties: Literal["tree", "pairs", "none"] = "tree"
    boxes: Literal["fitted", "predicted"] = "fitted"
    confidence: Share = 0.8
    trusted: Share = 0.2
    trusted_in_semi: Share = 0.5


@dataclass(frozen=True)
class RefinementConfig:
    """From edges to joints (paper, section 3.3).

    `weights` of feasibility, direction, position and swept freedom; `position` is the reading of s^p (`scoring`); `threshold`
    is the score above which a joint becomes a pseudo label (tau). Scores of kinmo's own method are chances to be right: above
    `chance` such a joint becomes one, and no part of the shape that is said to rest may move by a chance above `doubt`. `extra`
    names candidates beyond the paper's (`boxes`, `contact`, `symmetry`); `contact_pivots` says which axes have a second pivot
    in the interaction region (`candidates`).
    """

    weights: Annotated[tuple[Amount, ...], Within(3, 4)] = (0.5, 0.3, 0.2, 0.0)
    position: Literal["line", "printed"] = "line"
    threshold: Share = 0.6
    chance: Share = 0.3
    doubt: Share = 0.05
    extra: tuple[Literal["boxes", "contact", "symmetry"], ...] = ()
    contact_pivots: Literal["central", "revolute", "none"] = "central"

    def least_score(self, method: str) -> float:
        """What every joint of a pseudo label by `method` must exceed."""
        return self.threshold if method == "paper" else self.chance

    @property
    def sweeps(self) -> bool:
        """Whether the swept term counts."""
        return any(weight > 0 for weight in self.weights[3:])


@dataclass(frozen=True)
class Config:
    """Everything that may be chosen beforehand."""

    gnn: GnnConfig
    axis: AxisConfig
    ranking: RankingConfig
    ancsh: AncshConfig
    scans: ScansConfig = field(default_factory=ScansConfig)
    refinement: RefinementConfig = field(default_factory=RefinementConfig)


def load_config(name: str | Path) -> Config:
    """The configuration in a TOML file, or one of those that come with kinmo (`paper`, `small`) by name.

    A file that says `extends = "small"` need only say what is to differ from that.

    Raises InputError for a file that is absent or no TOML, an unknown or missing key, or a value of the wrong type.
    """
    path = _builtin_path(str(name)) if str(name) in builtin_configs() else Path(name)
    table = _read_table(path)
    is_whole = EXTENDS not in table
    if not is_whole:
        extended = table.pop(EXTENDS)
        if extended not in builtin_configs():
            raise InputError(path, f"{extended!r}, expected one of {', '.join(builtin_configs())}", EXTENDS)
        table = _merged(_read_table(_builtin_path(extended)), table)
    try:
        return from_table(Config, table, path)
    except InputError as error:
        if not is_whole or error.problem != "missing":
            raise
        problem = f'missing; a file that is to say only what differs begins with {EXTENDS} = "small"'
        raise InputError(path, problem, error.field) from None


def _builtin_path(name: str) -> Path:
    return Path(str(files("kinmo") / "configs" / f"{name}.toml"))


def _read_table(path: Path) -> dict[str, Any]:
    try:
        table: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        near, known = did_you_mean(str(path), builtin_configs()), ", ".join(builtin_configs())
        raise InputError(path, f"expected a TOML file or one of {known} ({error.strerror}){near}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(path, f"expected TOML ({error})") from error
    return table


def _merged(table: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """`table` with `changes`, key by key in tables of both."""
    both = {name: _merged(table[name], value) for name, value in changes.items() if _is_table(value, table.get(name))}
    return table | changes | both


def _is_table(*values: object) -> bool:
    return all(isinstance(value, dict) for value in values)


def builtin_configs() -> tuple[str, ...]:
    """Names of the configurations that come with kinmo."""
    return tuple(sorted(Path(str(f)).stem for f in (files("kinmo") / "configs").iterdir() if f.name.endswith(".toml")))
