"""Folder of an evaluation: its files, and the check that they are up to date. Nothing here needs torch."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from kinmo.core.errors import InputError
from kinmo.core.typed_tables import to_table
from kinmo.dataset.shape_dataset import ShapeDataset, fingerprint, open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.store import IndexEntry
from kinmo.dataset.workspace import Workspace
from kinmo.learning.model_folder import ModelFolder

SETTINGS = ("parts_given", "hierarchy_given")  # the two settings; each has a folder of tables
PRINTED_TABLES = ("overview_micro", "angle", "distance")  # printed with --details; all tables are written
EXAMPLES = "examples.jsonl"  # file of predictions for true joints, for the report's pictures
SUMMARIES = "summaries"  # folder with all figures of all rows, a file for each setting
SHAPE_SCORES = "shape_scores"  # folder of the scores of each test shape, below the workspace's evaluations
ALL = "all"  # folder of the evaluation of all categories; that of one category has the category's name


@dataclass(frozen=True)
class EvaluationFolder:
    """Folder and record of the evaluation of one category, spelled as in the index, or of all (None)."""

    workspace: Workspace
    category: str | None = None

    @property
    def name(self) -> str:
        """Name of the folder."""
        return quote(self.category.lower(), safe=" ") if self.category else ALL

    @property
    def path(self) -> Path:
        """The folder of the tables."""
        return self.workspace.evaluation / self.name

    @property
    def stage(self) -> str:
        """Name of the evaluation's record."""
        return f"evaluate-{self.name}"

    @property
    def is_current(self) -> bool:
        """True if the evaluation was finished, and its shapes, networks and settings are still the same."""
        recorded = self.workspace.inputs_of(self.stage)
        if recorded is None:
            return False
        try:
            now = workspace_inputs(self.workspace, self.category, recorded["weights"])
        except (InputError, KeyError):  # of another version, or with files that are gone
            return False
        return self.workspace.is_current(self.stage, recorded | now)


def workspace_inputs(workspace: Workspace, category: str | None, models: Iterable[str]) -> dict[str, Any]:
    """Everything in a workspace that an evaluation of a category (None for all) by some models depends on, as plain data.

    Raises InputError if there are no test shapes, or a file of the workspace cannot be read.
    """
    folder, every = ModelFolder(workspace.models), open_dataset(workspace)
    own = every if category is None else open_dataset(workspace, category)
    return {
        "test": fingerprint(test_shapes(own)),
        "training": fingerprint(every.labelled[Split.TRAIN]),
        "weights": {model: folder.digest((model,)) for model in models},
        "refinement": to_table(folder.config().refinement),
    }


def evaluation_folders(workspace: Workspace, categories: tuple[str, ...]) -> list[EvaluationFolder]:
    """Evaluations with tables, up to date or not: that of all categories, and those of single ones."""
    folders = [EvaluationFolder(workspace, category) for category in (None, *categories)]
    return [folder for folder in folders if any((folder.path / setting).is_dir() for setting in SETTINGS)]


def test_shapes(dataset: ShapeDataset) -> tuple[IndexEntry, ...]:
    """Test shapes with at least one joint. Raises InputError if there are none."""
    entries = tuple(entry for entry in dataset.labelled[Split.TEST] if entry.joint_count)
    if not entries:
        of = f" of {dataset.category}" if dataset.category else ""
        tests, known = len(dataset.labelled[Split.TEST]), sum(map(len, dataset.labelled.values()))
        found = f"{tests} of {known} shapes are in the test split"
        raise InputError(dataset.store.folder, f"expected a labelled test shape{of} with a joint; {found}: prepare more")
    return entries
