"""kinmo report."""

from __future__ import annotations

from kinmo.cli.execute import execute
from kinmo.cli.options import CommonOptions


def report(options: CommonOptions) -> None:
    """Write one HTML page about the workspace.

    What was run, the data, the tables beside the paper's, training curves, and pictures of right and wrong answers with their
    axes. It shows whatever is there already, is one file, and needs no network.

    For example:

        kinmo report
        kinmo report --workspace experiments/first
    """
    from kinmo.dataset.workspace import Workspace
    from kinmo.view.report import Report

    execute(options, Report(Workspace(options.workspace)))
