"""Forms of labelled shapes that the `kinmo` method learns from: as they are, as users' files, and as loose pieces.

The forms are prepared once, into the workspace. Later the candidate joints of the bodies that the grouping networks propose are
added to them (`add_proposals`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from safetensors.numpy import load, save

from kinmo import _core
from kinmo.config import RankingConfig
from kinmo.core.errors import InputError
from kinmo.core.normalisation import Normalisation
from kinmo.core.part_changes import changed_parts
from kinmo.core.shape import Shape
from kinmo.core.shape_forms import flat_parts, flat_shape, in_pieces
from kinmo.dataset.cache import Cache, cache_key
from kinmo.dataset.jobs import Failure, LocalRunner
from kinmo.dataset.stage import Observer
from kinmo.dataset.store import IndexEntry, file_name, read_prepared, to_bytes
from kinmo.dataset.workspace import Workspace
from kinmo.features.candidate_features import CandidateFeatures, with_groups
from kinmo.features.shape_geometry import ShapeGeometry
from kinmo.features.shape_preparation import prepare_shape
from kinmo.io.atomic_files import write_bytes_atomically
from kinmo.io.discover import ShapeSource
from kinmo.io.folder_lock import locked
from kinmo.methods.kinmo.grouping.part_grouper import PartGrouper
from kinmo.methods.kinmo.limits import travel_examples
from kinmo.methods.kinmo.limits.travel_examples import examples_of
from kinmo.methods.kinmo.ranking.training_views import training_groups
from kinmo.methods.method import load_network

FORMS = ("whole", "changed", "pieces")
"""The shape as it is, as a flat list of parts that were changed at random, and as loose pieces of one mesh."""
MAX_PIECES = 120
"""Most loose pieces of a shape in training."""
POINTS_PER_LEAF = 512
"""Surface samples per leaf."""


@dataclass(frozen=True)
class TrainingForms:
    """The prepared forms of a workspace's labelled shapes, and the same with proposals.

    The forms lie beside the prepared shapes, which several workspaces may share. The proposals lie in the workspace itself.
    """

    workspace: Workspace
    workers: int

    @property
    def folder(self) -> Path:
        """Folder of the forms."""
        return self.workspace.prepared.parent / "training_forms"

    @property
    def proposals_folder(self) -> Path:
        """Folder of the forms with proposals."""
        return self.workspace.path / "training_proposals"

    def files(self, entries: Sequence[IndexEntry]) -> list[Path]:
        """Files of the prepared forms of some shapes that have two parts or more."""
        return [path for entry in entries for form in FORMS if (path := self._path(entry, form)).exists()]

    def files_with_proposals(self, entries: Sequence[IndexEntry]) -> list[Path]:
        """Files of the same forms with the candidate joints of proposed bodies."""
        return [self.proposals_folder / path.relative_to(self.folder) for path in self.files(entries)]

    def files_of_limits(self, entries: Sequence[IndexEntry]) -> list[Path]:
        """Files of the joints of those forms that have joints, for the limits network."""
        return [path for form in self.files(entries) if (path := _limits_of(form)).exists()]

    def prepare(self, entries: Sequence[IndexEntry], observer: Observer) -> None:
        """Prepare the forms of labelled shapes.

        Raises:
            InputError: A shape cannot be read any more.
        """
        jobs = []
        for entry in entries:
            paths = tuple(self._path(entry, form) for form in FORMS)
            jobs.append(_FormsJob(entry, cache_key(entry=entry.key), paths))
        self._run(self.folder, _prepare_forms, jobs, "preparing forms", observer)

    def add_proposals(
        self, entries: Sequence[IndexEntry], grouping: Path, config: RankingConfig, key: str, observer: Observer
    ) -> None:
        """Add the candidate joints of bodies that grouping networks propose to the prepared forms of some shapes.

        Args:
            entries: Shapes whose forms are prepared.
            grouping: Weights of the grouping networks.
            config: Configuration of the ranking networks.
            key: Digest of everything that the weights depend on.
            observer: Receiver of progress.
        """
        jobs = []
        for entry in entries:
            own = cache_key(entry=entry.key, grouping=key, hide_names=config.hide_names)
            paths, made = tuple(self.files([entry])), tuple(self.files_with_proposals([entry]))
            jobs.append(_ProposalsJob(entry, own, paths, made, grouping, config))
        self._run(self.proposals_folder, _add_proposals, jobs, "proposing bodies", observer)

    def _path(self, entry: IndexEntry, form: str) -> Path:
        return (self.folder / file_name(entry.layout, entry.id)).with_suffix(f".{form}.safetensors")

    def _run(
        self, folder: Path, function: Callable[[Any], list[Path]], jobs: Sequence[_Job], what: str, observer: Observer
    ) -> None:
        """Make the files of all jobs in a folder that are not up to date."""
        with locked(folder):
            cache = Cache(folder)
            pending = [job for job in jobs if not cache.is_current(job.name, job.key)]
            done = len(jobs) - len(pending)
            with closing(LocalRunner(self.workers).run(function, pending)) as finished:  # no job outlives the lock
                for job, answer in finished:
                    if isinstance(answer, Failure):
                        raise ChildProcessError(f"{job.entry.id}: {what} failed: {answer.reason}")
                    cache.store(job.name, job.key, answer)
                    done += 1
                    observer.progress(what, done, len(jobs), job.entry.id)


@dataclass(frozen=True)
class _Job:
    """Work on one shape: the key of its result, and the files of its forms."""

    entry: IndexEntry
    key: str
    paths: tuple[Path, ...]

    @property
    def name(self) -> str:
        """Name of the result in the cache."""
        return file_name(self.entry.layout, self.entry.id)


@dataclass(frozen=True)
class _FormsJob(_Job):
    """Forms of one shape to prepare."""


@dataclass(frozen=True)
class _ProposalsJob(_Job):
    """Prepared forms of one shape that get proposals, written to the files `made`."""

    made: tuple[Path, ...]
    grouping: Path
    config: RankingConfig


def training_form(shape: Shape, form: str) -> Shape:
    """One of the `FORMS` of a labelled shape; what is random is drawn for the shape, the same at every call."""
    if form == "whole":
        return shape
    parts = flat_parts(shape)
    if form == "pieces":
        return flat_shape(shape, in_pieces(parts, most=MAX_PIECES))
    return flat_shape(shape, changed_parts(parts, np.random.default_rng(list(shape.id.encode()))))


def _prepare_forms(job: _FormsJob) -> list[Path]:
    shape = ShapeSource.of(job.entry).read()
    written = []
    for form, path in zip(FORMS, job.paths, strict=True):
        formed = training_form(shape, form)
        path.unlink(missing_ok=True)
        if len(formed.leaves) < 2:
            continue
        prepared = prepare_shape(formed, points=POINTS_PER_LEAF)
        frame = Normalisation(prepared.center, prepared.diagonal)
        meshes = [frame.mesh(mesh) for mesh in formed.meshes()]
        arrays = {
            "vertices": np.concatenate([mesh.vertices for mesh in meshes]).astype(np.float32),
            "faces": np.concatenate([mesh.faces for mesh in meshes]),
            "counts": np.array([(len(mesh.vertices), len(mesh.faces)) for mesh in meshes]),
        }
        write_bytes_atomically(_meshes_of(path), save(arrays))
        write_bytes_atomically(path, to_bytes(prepared))
        written += [path, _meshes_of(path)]
        _limits_of(path).unlink(missing_ok=True)
        joints = examples_of(prepared, _core.Meshes([mesh.vertices for mesh in meshes], [mesh.faces for mesh in meshes]))
        if joints is not None:
            write_bytes_atomically(_limits_of(path), travel_examples.to_bytes(joints))
            written.append(_limits_of(path))
    return written


def _add_proposals(job: _ProposalsJob) -> list[Path]:
    grouper: PartGrouper = load_network(PartGrouper.load, job.grouping, "cpu")
    for path, made in zip(job.paths, job.made, strict=True):
        shape = read_prepared(path)
        groups = training_groups(shape, grouper, job.config)
        known = CandidateFeatures.of(shape.candidate_features)
        found = with_groups(known, ShapeGeometry.of_prepared(shape, _read_meshes(_meshes_of(path))), groups)
        assert found is not None
        few = shape.leaf_points[:, :0], shape.leaf_normals[:, :0]  # ranking needs no samples
        small = replace(shape, candidate_features=found.arrays(), leaf_points=few[0], leaf_normals=few[1])
        write_bytes_atomically(made, to_bytes(small))
    return list(job.made)


def _read_meshes(path: Path) -> _core.Meshes:
    try:
        arrays = load(path.read_bytes())
    except (OSError, ValueError) as error:
        raise InputError(path, f"not the meshes of a shape ({error}): remove the folder and train again") from None
    ends = np.cumsum(arrays["counts"], axis=0)[:-1]
    vertices = np.split(arrays["vertices"].astype(np.float64), ends[:, 0])
    return _core.Meshes(vertices, np.split(arrays["faces"], ends[:, 1]))


def _meshes_of(path: Path) -> Path:
    return path.with_suffix(".meshes")


def _limits_of(path: Path) -> Path:
    return path.with_suffix(".limits")
