"""What evaluation leaves in a workspace, and whether it still holds. Nothing here needs torch."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from kinmo.core.errors import InputError
from kinmo.core.typed_tables import to_table
from kinmo.dataset.shape_dataset import Dataset, open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.store import IndexEntry
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.table1.trees import library_version
from kinmo.learning.model_folder import ModelFolder
from kinmo.methods import METHOD_MODELS

SETTINGS = ("parts_given", "hierarchy_given")
"""A folder of tables each."""
PRINTED = ("overview_micro", "angle", "distance")
"""The tables that go to the terminal; all of them are written."""
EXAMPLES = "examples.jsonl"
"""Answers to true joints, for the report's pictures."""
SUMMARIES = "summaries"
"""Folder of a file a setting: every figure of every row with its interval, over joints, over categories, and by category."""
TREES = "trees.json"
"""What boosted trees answer for the test shapes, for whatever evaluation asks next."""
JUDGEMENTS = "judgements"
"""Folder of a file a test shape: what all rows answered for it, and how that was judged."""
ALL = "all"
"""The folder of the evaluation of all categories; one of a single category has the category's name."""


@dataclass(frozen=True)
class Choice:
    """What is asked of an evaluation (`evaluate.Evaluate`); `category` is spelled as in the index."""

    methods: tuple[str, ...]
    category: str | None = None
    ablations: bool = False
    hidden_names: bool = False
    seed: int = 0

    @property
    def name(self) -> str:
        """Of the folder in `workspace.evaluation`."""
        return quote(self.category.lower(), safe=" ") if self.category else ALL

    @property
    def models(self) -> tuple[str, ...]:
        """The networks that have a say in it."""
        wanted = {model for method in self.methods for model in METHOD_MODELS[method]}
        if "paper" in self.methods:
            wanted |= {"gnn_coarse", "gnn_contact"} if self.ablations else {"gnn_coarse"}
        return tuple(sorted(wanted))


def evaluations(workspace: Workspace) -> list[str]:
    """The names of the evaluations that have a folder, whether they still hold or not."""
    return sorted(path.name for path in workspace.evaluation.glob("*") if any((path / each).is_dir() for each in SETTINGS))


def folder_of(workspace: Workspace, name: str) -> Path:
    """Where the tables of an evaluation are."""
    return workspace.evaluation / name


def stage_of(name: str) -> str:
    """What the record of an evaluation is called."""
    return f"eval-{name}"


def test_shapes(dataset: Dataset) -> tuple[IndexEntry, ...]:
    """The test shapes that have a joint. Raises InputError if there are none."""
    entries = tuple(entry for entry in dataset.labelled[Split.TEST] if entry.joint_count)
    if not entries:
        of = f" of {dataset.category}" if dataset.category else ""
        tests, known = len(dataset.labelled[Split.TEST]), sum(map(len, dataset.labelled.values()))
        problem = f"expected a labelled test shape{of} with a joint; hashes of ids make {tests} of {known} test shapes"
        raise InputError(dataset.store.folder, problem)
    return entries


def made_from(workspace: Workspace, choice: Choice) -> dict[str, Any]:
    """All that the figures of an evaluation depend on, as plain data."""
    dataset, whole = open_dataset(workspace, choice.category), open_dataset(workspace)
    return {
        "choice": asdict(choice),
        "test": dataset.fingerprint(test_shapes(dataset)),
        "training": whole.fingerprint(whole.labelled[Split.TRAIN]),
        "weights": {model: ModelFolder(workspace.motion.models).digest((model,)) for model in choice.models},
        "trees": library_version(),
        "refinement": to_table(ModelFolder(workspace.motion.models).config().refinement),
    }


def is_current(workspace: Workspace, name: str) -> bool:
    """Whether the evaluation called `name` was finished, and would come out the same if it were run now."""
    record = workspace.record(stage_of(name))
    if record is None:
        return False
    try:
        choice = Choice(**{**record.inputs["choice"], "methods": tuple(record.inputs["choice"]["methods"])})
        return workspace.is_current(stage_of(name), made_from(workspace, choice))
    except (InputError, KeyError, TypeError):  # of other inputs, or of what is not there any more
        return False
