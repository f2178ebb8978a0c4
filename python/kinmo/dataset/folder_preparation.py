"""Preparation of every shape below a folder: resumable, and on several processes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from kinmo.core.errors import InputError
from kinmo.core.wording import printable_path
from kinmo.dataset.cache import Cache, Result, cache_key
from kinmo.dataset.jobs import Failure, runner_for
from kinmo.dataset.jobs.runner import attempt
from kinmo.dataset.store import FORMAT, IndexEntry, entry_from_data, file_name, to_bytes, write_index
from kinmo.dataset.workspace import Workspace
from kinmo.features.shape_preparation import POINTS_PER_LEAF, prepare_shape
from kinmo.io.atomic_files import remove_leftovers, write_bytes_atomically
from kinmo.io.discover import WORKSPACE, ShapeSource, discover
from kinmo.io.readers import PARTNET_MOBILITY
from kinmo.io.readers.partnet_annotation import check_annotated
from kinmo.io.source_files import fingerprint, have_same_contents

ORACLE = "oracle"
"""Subfolder in which `kinmo synth --oracle` writes annotated copies of unlabelled shapes."""


@dataclass(frozen=True, slots=True)
class ReportEntry:
    """The outcome for one shape: its `id` (empty for a folder that cannot be opened), its `path`, and the `reasons`."""

    id: str
    path: str
    reasons: tuple[str, ...] = ()


@dataclass
class PreparationReport:
    """Shapes by outcome, sorted by path. A repaired shape is included, but listed only among `repaired`."""

    included: list[ReportEntry] = field(default_factory=list)
    repaired: list[ReportEntry] = field(default_factory=list)
    skipped: list[ReportEntry] = field(default_factory=list)
    new: int = 0
    """Number of shapes that were prepared now; the others were up to date."""

    def as_data(self) -> dict[str, list[dict[str, Any]]]:
        """Plain data: a list of entries for each of `included`, `repaired` and `skipped`."""
        return {
            name: [{**asdict(entry), "reasons": list(entry.reasons)} for entry in getattr(self, name)]
            for name in ("included", "repaired", "skipped")
        }


@dataclass(frozen=True)
class PreparationJob:
    """One shape to prepare into the file `target`, unless `cached` shows that it is up to date."""

    found: ShapeSource
    target: Path
    points: int
    seed: int
    cached: Result | None


@dataclass(frozen=True)
class PreparedFile:
    """The index entry of a prepared shape and the bytes of its file (None if up to date), or the `problem` with the shape."""

    entry: IndexEntry | None = None
    data: bytes | None = None
    problem: str = ""


def prepare_folder(
    root: Path,
    workspace: Workspace,
    *,
    workers: int = 1,
    seed: int = 0,
    points: int = POINTS_PER_LEAF,
    oracle: Sequence[Path] = (),
    cluster: str | None = None,
    on_progress: Callable[[int, int, str], None] = lambda done, total, name: None,
) -> PreparationReport:
    """Prepare all shapes below a folder into a workspace, and list them in its index.

    A shape that was prepared from the same files with the same settings is not prepared again. Of several copies of a shape the
    first readable one is included. Index and files do not depend on `workers`, nor on interruptions.

    Args:
        workspace: the workspace whose `prepared` folder gets them.
        seed: seed of the sampled points.
        points: samples per leaf part.
        oracle: folders whose labels are oracle labels (`IndexEntry.is_oracle`).
        cluster: address of a Ray cluster that runs the jobs; None for this machine.
        on_progress: called after each shape with the number of shapes done, the number of all shapes, and the id of the last.

    Raises:
        InputError: `root` or an oracle folder is no folder, no shape is below `root`, or another process works in the
            workspace. The index then stays as it was.
    """
    shapes, problems = _find_shapes(Path(root), workspace)
    with workspace.locked():
        store = workspace.prepared
        remove_leftovers(store)
        run = _Run(store, Cache(store), points, seed, _folders(oracle))
        run.report.skipped += [ReportEntry("", printable_path(error.where), (str(error),)) for error in problems]
        copies: dict[Path, list[ShapeSource]] = {}
        for found in shapes:
            copies.setdefault(run.target(found), []).append(found)
        jobs = (run.job(first) for first, *_ in copies.values())
        done = 0
        with closing(runner_for(workers, cluster).run(prepare_file, jobs)) as results:  # no job outlives the lock
            for job, result in results:
                run.settle(job, result)
                done += len(copies[job.target])
                on_progress(done, len(shapes), job.found.id)
        for first, *others in copies.values():
            run.settle_copies(first, others)
        write_index(store, run.entries)
        return run.finished_report()


def count_shapes(root: Path, workspace: Workspace) -> int:
    """Number of shapes at or below a folder, copies included. Raises InputError if there is none."""
    return len(_find_shapes(root, workspace)[0])


def _find_shapes(root: Path, workspace: Workspace) -> tuple[list[ShapeSource], list[InputError]]:
    """Shapes at or below a folder, at least one, and problems with folders. The workspace is skipped."""
    problems: list[InputError] = []
    shapes = list(discover(root, skip=(workspace.path,), report=problems.append))
    if shapes:
        return shapes, problems
    if (root / WORKSPACE).is_file():
        raise InputError(root, "is a workspace, which is skipped: expected the folder with the shapes")
    if workspace.path.resolve() in (root.resolve(), *root.resolve().parents):
        raise InputError(root, f"lies in the workspace {workspace.path}, which is skipped: name another --workspace")
    first = f"; {problems[0]}" if problems else ""
    raise InputError(root, f"expected at least one shape at or below it (docs/reference/formats.md lists formats){first}")


@dataclass
class _Run:
    """State of one run, in the process that writes the files."""

    store: Path
    cache: Cache
    points: int
    seed: int
    oracle: tuple[Path, ...]
    entries: list[IndexEntry] = field(default_factory=list)
    report: PreparationReport = field(default_factory=PreparationReport)
    copies: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Lines about identical copies, by the source that was read."""
    unreadable: set[Path] = field(default_factory=set)
    """Targets whose shape has a problem. A copy may be readable."""
    prepared: set[Path] = field(default_factory=set)
    """Targets that are in place."""

    def target(self, found: ShapeSource) -> Path:
        return self.store / file_name(found.layout, found.id)

    def job(self, found: ShapeSource) -> PreparationJob:
        cached = self.cache.find(file_name(found.layout, found.id))
        return PreparationJob(found, self.target(found), self.points, self.seed, cached)

    def settle(self, job: PreparationJob, result: PreparedFile | Failure) -> None:
        """Write what a worker made, and list it."""
        found = job.found
        self.unreadable.discard(job.target)
        if isinstance(result, Failure):  # a shape that may end a process is not tried again in this one
            result = PreparedFile(problem=str(InputError(printable_path(found.path), f"cannot be prepared: {result.reason}")))
            self._remove(job.target)
        elif result.entry is None:
            self.unreadable.add(job.target)
        if result.entry is None:
            self._skip(found, result.problem)
            return
        self.prepared.add(job.target)
        if result.data is not None:
            write_bytes_atomically(job.target, result.data)
            self.cache.store(result.entry.file, result.entry.key, [job.target], asdict(result.entry))
            self.report.new += 1
        is_oracle = any(found.path.resolve().is_relative_to(folder) for folder in self.oracle)
        self.entries.append(replace(result.entry, is_oracle=is_oracle))

    def settle_copies(self, first: ShapeSource, copies: Sequence[ShapeSource]) -> None:
        """Read copies until one is readable, if the first shape is not. Report the others."""
        target, read = self.target(first), first
        same = [copy for copy in copies if have_same_contents(copy, first)]
        others = [copy for copy in copies if copy not in same]
        while target in self.unreadable and others:
            read = others.pop(0)
            job = self.job(read)
            self.settle(job, attempt(prepare_file, job))
        if target in self.unreadable:
            self._remove(target)
        remark = "which cannot be prepared"
        if target in self.prepared:
            remark = f"which is read instead: {printable_path(read.path)}"
            same = same if read is first else [copy for copy in others if have_same_contents(copy, read)]
            if same:
                lines = tuple(f"identical copy skipped: {printable_path(copy.path)}" for copy in same)
                self.copies[str(read.path.absolute())] = lines
        for copy in others:
            if copy not in same:
                self._skip(copy, f"differs from another copy of {copy.id}, {remark}")

    def _skip(self, found: ShapeSource, reason: str) -> None:
        self.report.skipped.append(ReportEntry(found.id, printable_path(found.path), (reason,)))

    def _remove(self, target: Path) -> None:
        self.cache.forget(target.relative_to(self.store).as_posix())
        target.unlink(missing_ok=True)

    def finished_report(self) -> PreparationReport:
        self.report.skipped.sort(key=lambda entry: (entry.path, entry.id))
        for entry in sorted(self.entries, key=lambda entry: entry.source):
            row = ReportEntry(entry.id, printable_path(entry.source), entry.repairs + self.copies.get(entry.source, ()))
            (self.report.repaired if entry.repairs else self.report.included).append(row)
        return self.report


def _folders(paths: Sequence[Path]) -> tuple[Path, ...]:
    """The folders without links. Raises InputError for a path that is no folder."""
    for path in paths:
        if not path.is_dir():
            raise InputError(path, "expected a folder with shapes", "--oracle")
    return tuple(path.resolve() for path in paths)


def prepare_file(job: PreparationJob) -> PreparedFile:
    """Read and prepare one shape. A problem with the shape becomes the result's `problem`."""
    found = job.found
    try:
        if found.layout == PARTNET_MOBILITY:
            check_annotated(found.path)
        key = cache_key(files=fingerprint(found), points=job.points, seed=job.seed, format=FORMAT)
        source = str(found.path.absolute())
        if job.cached is not None and job.cached.key == key and job.cached.data["source"] == source:
            return PreparedFile(entry_from_data(job.cached.data))
        shape = found.read()
        prepared = prepare_shape(shape, points=job.points, seed=job.seed)
    except InputError as error:
        return PreparedFile(problem=str(error))
    entry = IndexEntry(
        id=shape.id,
        layout=shape.layout,
        category=shape.category,
        file=file_name(shape.layout, shape.id),
        source=source,
        key=key,
        partnet_id=shape.partnet_id,
        geometry_hash=prepared.geometry_hash,
        part_count=len(shape.parts),
        leaf_count=len(shape.leaves),
        joint_count=0 if shape.mobility is None else sum(1 for _ in shape.mobility.movable()),
        is_labelled=shape.mobility is not None,
        repairs=shape.repairs,
    )
    return PreparedFile(entry, to_bytes(prepared))
