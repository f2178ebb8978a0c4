"""kinmo pseudo-label."""

from __future__ import annotations

from typing import Annotated

from typer import Option

from kinmo.cli.execute import execute
from kinmo.cli.options import CommonOptions, Method


def pseudo_label(
    options: CommonOptions,
    category: Annotated[
        str | None, Option(help="Only shapes of this category, however it is spelled.", show_default=False)
    ] = None,
    method: Annotated[Method, Option(help="Which method labels.")] = Method.KINMO,
    threshold: Annotated[
        float | None,
        Option(min=0.0, max=1.0, help="Score that every joint of a shape must exceed.", show_default="0.3; of paper 0.6"),
    ] = None,
) -> None:
    """Give joints to the prepared shapes that have none.

    A shape whose joints all score above the threshold, and whose other parts surely rest, is written to pseudo/<id>/ in
    PartNet-Mobility's own layout, so that whatever reads that reads it too. Copies of labelled shapes are left alone.
    pseudo/acceptance.json says how many shapes and joints there are at which score, by category and type, and what was refused
    and why. Labels of --method paper lie beside those of kinmo, in by-paper/. kinmo train all and kinmo table label anew by the
    threshold of the configuration (refinement.chance; of paper refinement.threshold), whatever was said here.

    For example:

        kinmo pseudo-label
        kinmo pseudo-label --category refrigerator --threshold 0.8
    """
    from kinmo.dataset.workspace import Workspace
    from kinmo.pipeline.pseudo_label import PseudoLabel

    workspace = Workspace(options.workspace, method=method.value)
    execute(options, PseudoLabel(workspace, category, threshold, options.device, options.worker_count))
