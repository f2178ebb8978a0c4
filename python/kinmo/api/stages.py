"""Stages as functions: prepare, train, evaluate, export. The command line runs the same stages.

The stages are imported inside the functions: only training, prediction and evaluation load torch.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from kinmo.core.errors import InputError, did_you_mean
from kinmo.dataset.stage import Observer, Outcome, SilentObserver, Stage
from kinmo.dataset.workspace import Workspace
from kinmo.learning.model_folder import SHIPPED
from kinmo.methods import DEFAULT_METHOD, METHOD_MODELS

if TYPE_CHECKING:
    from kinmo.pipeline.scans.training_settings import Setting

Networks = Literal["all", "motion", "kinmo", "paper", "gnn", "axis", "contact-edges", "ancsh"]
"""Groups of networks: all, those for shapes or some of them, and those for scans."""


def prepare(
    folder: Path | str,
    workspace: Path | str = "workspace",
    *,
    oracle: Sequence[Path | str] = (),
    seed: int = 0,
    workers: int = 0,
    cluster: str | None = None,
    observer: Observer | None = None,
) -> Outcome:
    """Find, check and convert every shape below a folder.

    Unchanged shapes are not prepared again.

    Args:
        folder: Folder with shapes in any input format.
        workspace: Folder of the workspace.
        oracle: Folders whose labels are oracle labels: nothing is trained on them.
        seed: Seed of the sampled points.
        workers: Number of processes; 0 for one per CPU core.
        cluster: Address of a Ray cluster that runs the jobs; None for this machine.
        observer: Receiver of progress and messages.

    Returns:
        The outcome; `data` lists included, repaired and skipped shapes.

    Raises:
        InputError: There is no shape.

    Example:
        >>> outcome = kinmo.prepare("partnet/")
        >>> len(outcome.data["included"])
    """
    from kinmo.pipeline.prepare_shapes import Prepare

    folders = tuple(map(Path, oracle))
    stage = Prepare(Path(folder), Workspace(workspace), worker_count(workers), seed, folders, cluster)
    return stage.run(observer or SilentObserver())


def train(
    networks: Networks = "all",
    workspace: Path | str = "workspace",
    *,
    config: str = "small",
    category: str | None = None,
    method: str = DEFAULT_METHOD,
    setting: Setting = "semi-weakly",
    start: Path | str | None = None,
    seed: int = 0,
    device: str = "auto",
    workers: int = 0,
    observer: Observer | None = None,
) -> Outcome:
    """Train networks. Finished networks stay, and an interrupted training continues.

    Args:
        networks: `all` trains the motion networks, pseudo-labels unlabelled shapes, scans both, and trains networks for scans.
            `motion` trains all networks for shapes, `gnn` and `axis` some of them, `ancsh` the networks for scans.
        workspace: Folder of the workspace.
        config: `small` for a CPU, `paper` for a GPU, or the path of a TOML file.
        category: Train for this category alone; with `all`, the motion networks still see all categories.
        method: Method that gives the pseudo labels.
        setting: Labels for `ancsh` besides those of the labelled shapes.
        start: Folder of a workspace whose networks the `kinmo` method continues from; `shipped`: those that come with kinmo.
        seed: Seed of everything random.
        device: Where networks are trained: auto, cpu, cuda, cuda:1, mps.
        workers: Number of processes; 0 for one per CPU core.
        observer: Receiver of progress and messages.

    Returns:
        The outcome; `data` has epochs and validation error of every network.

    Raises:
        InputError: There are no such networks, there is nothing to train on, or the configuration is wrong.

    Example:
        >>> kinmo.train("motion", "workspace")
    """
    stage = train_stage(networks, workspace, config, category, method, setting, start, seed, device, workers)
    return stage.run(observer or SilentObserver())


def start_workspace(start: Path | str | None) -> Workspace | None:
    """The workspace that training continues from: a folder, or `shipped` for the networks that come with kinmo."""
    return None if start is None else Workspace(SHIPPED if str(start) == "shipped" else start)


def train_stage(
    networks: Networks,
    workspace: Path | str,
    config: str,
    category: str | None,
    method: str,
    setting: Setting,
    start: Path | str | None,
    seed: int,
    device: str,
    workers: int,
) -> Stage:
    """The stage that `train` runs. Raises InputError for unknown names, and for networks for scans with a `start`."""
    _check_name("method", method, METHOD_MODELS)
    place, count = Workspace(workspace), worker_count(workers)
    origin = start_workspace(start)
    if networks == "all":
        from kinmo.pipeline.train_all import TrainAll

        return TrainAll(place, config, category, method, seed, device, count, origin)
    if networks == "ancsh":
        if origin is not None:
            raise InputError("--from", "ancsh cannot start from trained weights; use it with all, motion or kinmo")
        from kinmo.pipeline.scans.train_scans import TrainScans
        from kinmo.pipeline.scans.training_settings import SETTINGS

        _check_name("setting", setting, SETTINGS)
        return TrainScans(place, config, category, setting, method, seed, device, count)
    from kinmo.pipeline.motion_models import GROUPS
    from kinmo.pipeline.train_motion import TrainMotion

    _check_name("networks", networks, ("all", *GROUPS, "ancsh"))
    return TrainMotion(networks, place, config, category, seed, device, count, origin)


def evaluate(
    workspace: Path | str = "workspace",
    *,
    category: str | None = None,
    methods: Sequence[str] = tuple(METHOD_MODELS),
    device: str = "auto",
    workers: int = 0,
    observer: Observer | None = None,
) -> Outcome:
    """Score the trained methods on the test shapes of a workspace (paper, Table 1).

    Tables of `kinmo eval` for the same methods also have baselines. While they are up to date, they stay and are returned.

    Args:
        workspace: Folder of the workspace.
        category: Only shapes of this category, in any spelling.
        methods: Methods to score.
        device: Where networks run.
        workers: Number of processes; 0 for one per CPU core.
        observer: Receiver of progress and messages.

    Returns:
        The outcome; `data` has the tables by setting (`parts_given`, `hierarchy_given`) and name.

    Raises:
        InputError: Nothing is trained, or there is no test shape.

    Example:
        >>> outcome = kinmo.evaluate("workspace")
        >>> outcome.data["parts_given"]["summary"]["rows"]
    """
    from kinmo.pipeline.evaluation.evaluate_shapes import EvaluateShapes

    stage = EvaluateShapes(Workspace(workspace), tuple(methods), category, device=device, workers=worker_count(workers))
    return stage.run(observer or SilentObserver())


def export(
    results: Path | str,
    *,
    formats: Sequence[str] = (),
    out: Path | str | None = None,
    source: Path | str | None = None,
    workers: int = 0,
    observer: Observer | None = None,
) -> Outcome:
    """Export predictions again, with the corrections of the overrides.toml beside each joints.json. No network is needed.

    Args:
        results: Folder of one prediction, or of many.
        formats: Names of formats (`kinmo.io.writers.WRITERS`). Empty for those of each folder.
        out: Folder in which each prediction gets a folder. None to write the folders of the predictions again. These keep their
            own formats, and files that kinmo did not write.
        source: File or folder of the shape, if it is in another place than joints.json says; for one prediction alone.
        workers: Number of processes; 0 for one per CPU core.
        observer: Receiver of progress and messages.

    Returns:
        The outcome; `data` lists results with their files, and messages about those that were skipped.

    Raises:
        InputError: There is no prediction, or no such format.

    Example:
        >>> outcome = kinmo.export("out/cabinet", formats=["urdf"])
        >>> outcome.data["results"][0]["files"]["urdf"]
    """
    from kinmo.pipeline.export_results import ExportResults

    place, file = None if out is None else Path(out), None if source is None else Path(source)
    return ExportResults(Path(results), tuple(formats), place, file, worker_count(workers)).run(observer or SilentObserver())


def worker_count(workers: int) -> int:
    """Number of processes; 0 stands for the number of CPU cores that this process may use."""
    return workers or len(os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else range(os.cpu_count() or 1))


def _check_name(argument: str, name: str, known: Collection[str]) -> None:
    if name not in known:
        raise InputError(argument, f"expected one of {', '.join(known)}, got {name}{did_you_mean(name, known)}")
