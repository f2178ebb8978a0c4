"""kinmo eval."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Argument, BadParameter, Option

from kinmo.cli.execute import execute
from kinmo.cli.options import CommonOptions, Method, ProtocolName
from kinmo.core.errors import InputError


def evaluate(
    options: CommonOptions,
    files: Annotated[Path | None, Argument(help="Folder of URDF files to score instead.", show_default=False)] = None,
    truth: Annotated[
        Path | None, Option(help="Folder of PartNet-Mobility shapes to score the URDF files by.", show_default=False)
    ] = None,
    category: Annotated[
        str | None, Option(help="Only shapes of this category, however it is spelled.", show_default=False)
    ] = None,
    method: Annotated[Method | None, Option(help="Of Table 1, only the rows of this method.", show_default="all")] = None,
    ablations: Annotated[bool, Option("--ablations", help="Add rows with other candidates, terms and edges.")] = False,
    hidden_names: Annotated[bool, Option("--hidden-names", help="Add rows with all part names hidden.")] = False,
    protocol: Annotated[
        ProtocolName, Option(help="How scans are measured: rightly, or as ANCSH's public code does, faults included.")
    ] = ProtocolName.KINMO,
) -> None:
    """Print the paper's tables for the test shapes and scans, beside the printed figures.

    Table 1 in both settings: parts given (as in the paper) and hierarchy given (what a user has). Tables 2 to 4 as far as
    networks are trained for scans (kinmo train ancsh, kinmo table). All tables, also as JSON, CSV, Markdown
    and LaTeX, are in the folder on the last line; docs/metrics.md says what every figure means. With FILES and --truth,
    anybody's URDF files are scored against annotated shapes by the same measures.

    For example:

        kinmo eval
        kinmo eval --category refrigerator --ablations
        kinmo eval out/ --truth partnet/
    """
    from kinmo.dataset.workspace import Workspace

    workspace = Workspace(options.workspace)
    if (files is None) != (truth is None):
        raise BadParameter("FILES and --truth go together", param_hint="--truth")
    if files is not None and truth is not None:
        from kinmo.pipeline.score_urdfs import ScoreUrdfs

        given = {
            "--method": method is not None,
            "--ablations": ablations,
            "--hidden-names": hidden_names,
            "--protocol": protocol is not ProtocolName.KINMO,
        }
        for name in (name for name, is_given in given.items() if is_given):
            raise InputError(name, "applies only to the workspace's own shapes and scans, not to FILES")
        execute(options, ScoreUrdfs(files, truth, workspace, category, options.worker_count))
        return
    from kinmo.experiments.evaluate_all import EvaluateAll
    from kinmo.experiments.scan_tables.evaluate_trained import JudgeTrained
    from kinmo.experiments.table1.evaluate_table1 import Evaluate

    methods = tuple(each.value for each in Method) if method is None else (method.value,)
    stage = Evaluate(workspace, methods, category, ablations, hidden_names, options.seed, options.device, options.worker_count)
    execute(options, EvaluateAll(stage, JudgeTrained(workspace, category, protocol.value, options.device)))
