"""What the baseline of boosted trees answers: fitted once, and kept until what it is fitted on changes."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from kinmo._core import __version__
from kinmo.core.digest import digest
from kinmo.core.joint import MotionType, joint_from_data, joint_to_data
from kinmo.core.prediction import JointEstimate
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.stage import Observer
from kinmo.dataset.store import IndexEntry
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.table1.evaluation_folder import TREES, test_shapes
from kinmo.experiments.table1.trees import library_version
from kinmo.experiments.table1.trees_baseline import fit_trees
from kinmo.io.atomic_files import write_text_atomically

SEEDS = 1 << 32
"""As many as scikit-learn knows."""
MOST_SHAPES = 1000
"""The baseline is trained on no more."""

Answers = Mapping[int, JointEstimate]
"""By body of a shape, in the normalised frame."""


def trees_answers(workspace: Workspace, seed: int, observer: Observer) -> dict[str, Answers] | None:
    """The answers for every test shape, *parts given*, by the shape's file in the store.

    Trained on what the networks were trained on. None without scikit-learn or any joint to learn from, which the observer is
    told.
    """
    dataset = open_dataset(workspace)
    training, asked = evenly(dataset.labelled[Split.TRAIN], MOST_SHAPES), test_shapes(dataset)
    if not any(entry.joint_count for entry in training):
        observer.note("no row of boosted trees: there is no labelled shape with a joint to train them on")
        return None
    path = workspace.evaluation / TREES
    made_from = digest([dataset.fingerprint(training), dataset.fingerprint(asked), seed, library_version(), __version__])
    known = _read(path, made_from)
    if known is not None:
        return known
    try:
        trees = fit_trees(map(dataset.store.load, training), seed=seed % SEEDS)
    except ImportError as error:
        observer.note(str(error))
        return None
    found = {}
    for done, entry in enumerate(asked, start=1):
        answers = trees.answers(dataset.store.load(entry))
        found[entry.file] = {str(body): answer_to_data(answer) for body, answer in answers.items()}
        observer.progress("asking boosted trees", done, len(asked), entry.id)
    write_text_atomically(path, json.dumps({"made_from": made_from, "answers": found}) + "\n")
    return _read(path, made_from)


def evenly(entries: Sequence[IndexEntry], most: int) -> Sequence[IndexEntry]:
    """At most so many of some entries, spread over all of them."""
    return entries[:: max(1, -(-len(entries) // most))]


def _read(path: Path, made_from: str) -> dict[str, Answers] | None:
    """The answers of a file; None if there are none, or they were made from something else."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        if data["made_from"] != made_from:
            return None
        return {
            file: {int(body): answer_from_data(answer) for body, answer in answers.items()}
            for file, answers in data["answers"].items()
        }
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


def answer_to_data(answer: JointEstimate) -> dict[str, Any]:
    """An answer of the trees as plain data."""
    joint = None if answer.joint is None else joint_to_data(answer.joint)
    return {"type": answer.type.name, "score": float(answer.score), "joint": joint}


def answer_from_data(data: Mapping[str, Any]) -> JointEstimate:
    """What `answer_to_data` took apart."""
    joint = None if data["joint"] is None else joint_from_data(data["joint"])
    return JointEstimate(joint, MotionType[data["type"]], data["score"], source="trees")
