"""The command `kinmo eval`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, get_args

from typer import Argument, BadParameter, Option

from kinmo.cli.execute import execute
from kinmo.cli.options import Category, CommonOptions, Details, MethodName, ProtocolName, refuse


def evaluate(
    options: CommonOptions,
    files: Annotated[Path | None, Argument(help="Folder of URDF files to score instead.", show_default=False)] = None,
    truth: Annotated[
        Path | None, Option(help="Folder of PartNet-Mobility shapes to score the URDF files against.", show_default=False)
    ] = None,
    category: Category = None,
    method: Annotated[MethodName | None, Option(help="Table 1: only rows of this method.", show_default="all")] = None,
    details: Details = False,
    ablations: Annotated[bool, Option("--ablations", help="Add rows with other candidates, terms and edges.")] = False,
    hidden_names: Annotated[bool, Option("--hidden-names", help="Add rows with all part names hidden.")] = False,
    protocol: Annotated[
        ProtocolName, Option(help="Errors of scans as kinmo defines them, or as ANCSH's public code computes them.")
    ] = "kinmo",
) -> None:
    """Print the paper's tables for the test shapes and scans.

    Table 1 is printed for both settings: parts given (as in the paper) and hierarchy given (what users have). Tables 2 to 4
    follow for all trained networks for scans. The folder on the last line has all tables with all figures, beside the printed
    ones, as JSON, CSV, Markdown and LaTeX. docs/background/metrics.md defines every figure. With FILES and --truth, the URDF
    files of any tool are scored against annotated shapes with the same measures.

    For example:

        kinmo eval
        kinmo eval --category refrigerator --ablations --details
        kinmo eval out/ --truth partnet/
    """
    from kinmo.dataset.workspace import Workspace

    workspace = Workspace(options.workspace)
    if (files is None) != (truth is None):
        raise BadParameter("FILES and --truth go together", param_hint="--truth")
    if files is not None and truth is not None:
        from kinmo.pipeline.score_urdfs import ScoreUrdfs

        given = {"--method": method, "--details": details, "--ablations": ablations, "--hidden-names": hidden_names}
        given |= {"--protocol": protocol != "kinmo"}
        refuse(given, "applies only to the workspace's own shapes and scans, not to FILES")
        execute(options, ScoreUrdfs(files, truth, workspace, category, options.worker_count))
        return
    from kinmo.experiments.evaluate_all import EvaluateAll
    from kinmo.experiments.label_truth import label_truth_tables
    from kinmo.experiments.scan_tables.evaluate_trained import EvaluateTrained
    from kinmo.experiments.table1.ablations import AblationRows
    from kinmo.experiments.table1.baselines import PaperBaselines
    from kinmo.learning.model_folder import ModelFolder
    from kinmo.pipeline.evaluation.evaluate_shapes import EvaluateShapes

    shapes = EvaluateShapes(
        workspace,
        methods=get_args(MethodName) if method is None else (method,),
        category=category,
        baselines=PaperBaselines(ModelFolder(workspace.models).config().refinement, options.seed),
        more_rows=AblationRows(ablations, hidden_names),
        more_tables=label_truth_tables,
        device=options.device,
        workers=options.worker_count,
        details=details,
    )
    scans = EvaluateTrained(workspace, category, protocol, options.device, details)
    execute(options, EvaluateAll(shapes, scans))
