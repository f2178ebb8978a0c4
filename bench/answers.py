"""Labelling shapes and judging test shapes of a workspace with trained motion networks, on one thread, without starting up.

    python bench/answers.py WORKSPACE [--shapes 25]

Prints processor seconds a shape: of labelling by `kinmo` (read, predicted, written), and of judging by all rows of Table 1
(by both methods, parts given, types told, and the hierarchy given). To compare two states of the code, run it in both, one
after the other.
"""

from __future__ import annotations

import argparse
import json
import os
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

for variable in ("RAYON_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import torch

from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.table1.evaluation_folder import test_shapes
from kinmo.experiments.table1.kept_scores import Job as JudgeJob
from kinmo.experiments.table1.kept_scores import Judge
from kinmo.experiments.table1.rows import chosen_rows
from kinmo.experiments.table1.trees_answers import evenly
from kinmo.learning.model_folder import ModelFolder
from kinmo.methods import load_method
from kinmo.pipeline.pseudo_label import Job as LabelJob
from kinmo.pipeline.pseudo_label import Labelling


def seconds_each(work: Callable[[Any], object], jobs: Sequence[Any]) -> float:
    """Processor time of a job; the first is done once before, to load networks."""
    work(jobs[0])
    start = time.process_time()
    for job in jobs:
        work(job)
    return (time.process_time() - start) / len(jobs)


def main() -> None:
    """Times both."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("workspace", type=Path)
    parser.add_argument("--shapes", type=int, default=25, help="at most so many of either")
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    workspace = Workspace(arguments.workspace)
    dataset, refinement = open_dataset(workspace), ModelFolder(workspace.motion.models).config().refinement
    labelling = Labelling(
        workspace.prepared,
        load_method("kinmo", ModelFolder(workspace.models), "cpu"),
        refinement.least_score("kinmo"),
        refinement.doubt,
    )
    judging = Judge(dataset.store.folder, tuple(chosen_rows(workspace, ("kinmo", "paper"), "cpu")), refinement)
    tests = [JudgeJob(entry, None, "") for entry in evenly(test_shapes(dataset), arguments.shapes)]
    with tempfile.TemporaryDirectory() as folder:
        unlabelled = [
            LabelJob(entry, Path(folder) / str(number), "")
            for number, entry in enumerate(evenly(dataset.unlabelled, arguments.shapes))
        ]
        label = seconds_each(labelling, unlabelled)
    judge = seconds_each(judging, tests)
    print(f"labelling a shape {label:.2f} s ({len(unlabelled)} shapes), judging one {judge:.2f} s ({len(tests)})")
    print(json.dumps({"claim": "processor seconds a shape", "label": label, "judge": judge}))


if __name__ == "__main__":
    main()
