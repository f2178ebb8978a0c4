"""The command `kinmo pseudo-label`."""

from __future__ import annotations

from typing import Annotated

from typer import Option

from kinmo.cli.execute import execute
from kinmo.cli.options import Category, Cluster, CommonOptions, MethodName


def pseudo_label(
    options: CommonOptions,
    category: Category = None,
    method: Annotated[MethodName, Option(help="Method that predicts the labels.")] = "kinmo",
    threshold: Annotated[
        float | None,
        Option(min=0.0, max=1.0, help="Score that every joint of a shape must exceed.", show_default="0.3; of paper 0.6"),
    ] = None,
    cluster: Cluster = None,
) -> None:
    """Predict joints for the unlabelled prepared shapes, and keep the certain ones as labels.

    A shape is accepted if all its joints score above the threshold and its other parts surely rest. It is written to
    pseudo_labels/METHOD/ID/ in PartNet-Mobility's layout. Copies of labelled shapes are skipped. The file acceptance.json
    beside the labels counts shapes and joints by score, category and type, with the reasons of refusals. kinmo train all and
    kinmo table use the thresholds of the configuration (refinement.chance, and refinement.threshold for paper).

    For example:

        kinmo pseudo-label
        kinmo pseudo-label --category refrigerator --threshold 0.8
    """
    from kinmo.dataset.workspace import Workspace
    from kinmo.pipeline.pseudo_label_shapes import PseudoLabel

    workspace, count = Workspace(options.workspace), options.worker_count
    execute(options, PseudoLabel(workspace, category, method, threshold, options.device, count, cluster))
