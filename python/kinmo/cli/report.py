"""The command `kinmo report`."""

from __future__ import annotations

from kinmo.cli.execute import execute
from kinmo.cli.options import CommonOptions


def report(options: CommonOptions) -> None:
    """Write one HTML page about the workspace.

    The page shows right and wrong predictions with their axes, each also in 3D, summaries of all tables, and folded details:
    all tables, the data, pseudo labels, training curves and runs. It is one file that fetches nothing.

    For example:

        kinmo report
        kinmo report --workspace experiments/first
    """
    from kinmo.dataset.workspace import Workspace
    from kinmo.view.html_report import Report

    execute(options, Report(Workspace(options.workspace)))
