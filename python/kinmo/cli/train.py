"""kinmo train."""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING, Annotated

from typer import Argument, Option

from kinmo.cli.execute import execute
from kinmo.cli.options import CommonOptions, Method, Start
from kinmo.core.errors import InputError

if TYPE_CHECKING:
    from kinmo.pipeline.scans.training_settings import Setting


class What(str, Enum):
    """The groups of `kinmo.pipeline.motion_models`, without importing it, and the networks that see scans."""

    ALL = "all"
    MOTION = "motion"
    GNN = "gnn"
    AXIS = "axis"
    ANCSH = "ancsh"
    CONTACT_EDGES = "contact-edges"


class SettingName(str, Enum):
    """The settings of `kinmo.pipeline.scans.training_settings`, without importing it."""

    SUPERVISED = "supervised"
    SEMI = "semi"
    SEMI_WEAKLY = "semi-weakly"
    DSG_NET = "dsg-net"
    CEILING = "ceiling"


def train(
    options: CommonOptions,
    what: Annotated[What, Argument(help="Which networks to train.", show_default=False)],
    config: Annotated[str, Option("--config", "-c", help="small (a CPU), paper (a GPU), or a TOML file.")] = "small",
    category: Annotated[
        str | None, Option(help="Only shapes of this category, however it is spelled.", show_default=False)
    ] = None,
    start: Start = None,
    setting: Annotated[
        SettingName | None,
        Option(help="ancsh: which labels count beside those of the labelled shapes.", show_default="semi-weakly"),
    ] = None,
    method: Annotated[
        Method | None, Option(help="all, ancsh: which method gives, or gave, pseudo labels.", show_default="kinmo")
    ] = None,
) -> None:
    """Train the networks.

    all goes the whole way: motion on the labelled shapes, pseudo labels for the others (kinmo pseudo-label), scans of both
    (kinmo render), and ancsh, for --category or for those of the paper that there are labelled shapes of. Motion networks
    always see all categories then.

    motion is gnn and axis. gnn predicts how neighbouring parts move against each other (with ten motion types, and with five).
    axis trains what chooses among candidate axes: the paper's axis selection and kinmo's own ranking. contact-edges, no part of
    motion, is the gnn on edges between touching parts alone, for a row of kinmo eval --ablations. Trained for a --category,
    these lie beside those of all, and that category goes by them from then on. ancsh finds parts, poses and joints in one depth
    scan; it is trained on scans, for a category at a time.

    The best epoch is chosen on validation shapes (of ancsh the last one is kept, and with --from too, halfway to what it went
    on from); test shapes are never looked at. Training that was stopped goes on from its last epoch. Networks that take one
    thread each, as those of small do, are trained side by side, four at most on a GPU.

    With few annotated shapes, train on many procedural ones in a workspace of their own, and go on from those with --from.

    For example:

        kinmo train all
        kinmo train all --category refrigerator
        kinmo train gnn --config paper --device cuda
        kinmo train axis --category laptop
        kinmo train ancsh --category refrigerator --setting supervised
        kinmo train motion --workspace real --from many
    """
    from kinmo.dataset.workspace import Workspace
    from kinmo.pipeline.scans.train_scans import TrainAncsh
    from kinmo.pipeline.scans.training_settings import PSEUDO_LABELLED
    from kinmo.pipeline.train_all import TrainAll
    from kinmo.pipeline.train_motion import Train

    if setting is not None and what is not What.ANCSH:
        raise InputError("--setting", "applies only to kinmo train ancsh")
    if method is not None and what not in (What.ALL, What.ANCSH):
        raise InputError("--method", "applies only to kinmo train all and ancsh")
    workspace = Workspace(options.workspace, method=(method or Method.KINMO).value)
    continued = None if start is None else Workspace(start)
    how = (options.seed, options.device, options.worker_count)
    if what is What.ALL:
        execute(options, TrainAll(workspace, config, category, *how, continued))
    elif what is What.ANCSH:
        if continued is not None:
            raise InputError("--from", "ancsh cannot start from trained weights; use it with all, motion or axis")
        learnt_from: Setting = (setting or SettingName.SEMI_WEAKLY).value
        if method is not None and learnt_from not in PSEUDO_LABELLED:
            raise InputError("--method", f"applies only to settings with pseudo labels, not to {learnt_from}")
        execute(options, TrainAncsh(workspace, config, category, learnt_from, *how))
    else:
        execute(options, Train(what.value, workspace, config, category, *how, continued))
