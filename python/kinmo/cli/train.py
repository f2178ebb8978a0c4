"""The command `kinmo train`."""

from __future__ import annotations

from typing import Annotated, Literal

from typer import Argument, Option

from kinmo.cli.execute import execute
from kinmo.cli.options import Category, CommonOptions, Config, MethodName, Start
from kinmo.core.errors import InputError

NetworksName = Literal["all", "motion", "kinmo", "paper", "gnn", "axis", "ancsh", "contact-edges"]
"""Groups of networks of `kinmo.train`."""
SettingName = Literal["supervised", "self-training", "semi-weakly", "oracle"]
"""Settings of `kinmo.pipeline.scans.training_settings`."""


def train(
    options: CommonOptions,
    networks: Annotated[NetworksName, Argument(help="Networks to train.", show_default=False)],
    config: Config = "small",
    category: Category = None,
    start: Start = None,
    setting: Annotated[
        SettingName | None,
        Option(help="ancsh: labels besides those of the labelled shapes.", show_default="semi-weakly"),
    ] = None,
    method: Annotated[
        MethodName | None, Option(help="all, ancsh: method that gives the pseudo labels.", show_default="kinmo")
    ] = None,
) -> None:
    """Train networks.

    The networks are:

        all             motion for all categories, then pseudo labels, scans, and ancsh
        motion          those of both methods, kinmo and paper
        kinmo           grouping of parts into bodies, ranking of candidate joints, limits of joints
        paper           motion between neighbouring parts, with ten types, and axis
        gnn             motion between neighbouring parts, with ten and with five types
        axis            choice among candidate axes
        ancsh           parts, poses and joints in a depth scan
        contact-edges   gnn on edges between touching parts, for kinmo eval --ablations

    With --category, networks for shapes serve that category alone, beside those for all. With all, --category chooses the scans
    (by default the paper's five categories).

    Validation shapes choose the best epoch; ancsh keeps its last one. Test shapes are never used. An interrupted training
    continues from its last epoch. With few annotated shapes, continue from the networks that come with kinmo (--from shipped),
    or train on many procedural shapes in another workspace and continue from there.

    For example:

        kinmo train all
        kinmo train all --category refrigerator
        kinmo train gnn --config paper --device cuda
        kinmo train kinmo --from shipped
        kinmo train axis --category laptop
        kinmo train ancsh --category refrigerator --setting supervised
        kinmo train motion --workspace real --from many
    """
    from kinmo.api.stages import train_stage

    if setting is not None and networks != "ancsh":
        raise InputError("--setting", "applies only to kinmo train ancsh")
    if method is not None and networks not in ("all", "ancsh"):
        raise InputError("--method", "applies only to kinmo train all and ancsh")
    setting = setting or "semi-weakly"
    if method is not None and networks == "ancsh" and setting != "semi-weakly":
        raise InputError("--method", f"applies only to the setting semi-weakly, not to {setting}")
    if setting == "self-training":
        from kinmo.dataset.workspace import Workspace
        from kinmo.experiments.self_training.train_by_self_training import TrainBySelfTraining

        if start is not None:
            raise InputError("--from", "ancsh cannot start from trained weights; use it with all, motion or kinmo")
        workspace, count = Workspace(options.workspace), options.worker_count
        execute(options, TrainBySelfTraining(workspace, config, category, options.seed, options.device, count))
        return
    place, method, device, workers = options.workspace, method or "kinmo", options.device, options.workers
    execute(options, train_stage(networks, place, config, category, method, setting, start, options.seed, device, workers))
