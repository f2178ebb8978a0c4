"""Preparing every shape below a folder, resumably and on several processes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from kinmo._core import __version__
from kinmo.core.digest import digest
from kinmo.core.errors import InputError
from kinmo.dataset.store import FORMAT, INDEX, IndexEntry, file_name, index_text, read_header, to_bytes
from kinmo.dataset.workers import Crashed, map_unordered, or_crashed
from kinmo.dataset.workspace import Workspace
from kinmo.features.shape_preparation import POINTS, prepare_shape
from kinmo.io.atomic_files import remove_leftovers, write_bytes_atomically, write_text_atomically
from kinmo.io.readers import Found, Layout, discover, read_found
from kinmo.io.readers.discover import WORKSPACE
from kinmo.io.readers.partnet_annotation import check_annotated
from kinmo.io.readers.sources import are_alike, fingerprint, shown

HELD_BACK = "held_back"
"""Subfolder in which `kinmo synth` writes annotated copies of unlabelled shapes."""

Progress = Callable[[int, int, str], None]
"""Called with the number of shapes done so far, the number there are, and the last one's id."""


@dataclass(frozen=True, slots=True)
class Entry:
    """What became of one shape. `id` is empty for a folder or link that could not be looked into."""

    id: str
    path: str
    reasons: tuple[str, ...] = ()


@dataclass
class PrepareReport:
    """Shapes by what became of them, sorted by path. Repaired ones are taken too, but are not listed among `taken`."""

    taken: list[Entry] = field(default_factory=list)
    repaired: list[Entry] = field(default_factory=list)
    left_out: list[Entry] = field(default_factory=list)
    made: int = 0
    """How many were prepared now; the rest was there from before."""

    def as_data(self) -> dict[str, list[dict[str, Any]]]:
        """Plain data: {"taken": [...], "repaired": [...], "left_out": [...]}, each entry with id, path and reasons."""
        return {
            name: [{**asdict(entry), "reasons": list(entry.reasons)} for entry in getattr(self, name)]
            for name in ("taken", "repaired", "left_out")
        }


@dataclass(frozen=True)
class Job:
    """One shape to prepare, if it is not yet prepared from the same files in the same way."""

    found: Found
    target: Path
    points: int
    seed: int


@dataclass(frozen=True)
class Result:
    """A line of the index and a file's bytes (None if the file is there already), or the `problem` why there are none."""

    job: Job
    entry: IndexEntry | None = None
    data: bytes | None = None
    problem: str = ""


def prepare_folder(
    root: Path,
    workspace: Workspace,
    *,
    workers: int = 1,
    seed: int = 0,
    points: int = POINTS,
    hold_back: Sequence[Path] = (),
    on_progress: Progress = lambda done, total, name: None,
) -> PrepareReport:
    """Prepares all shapes below `root` into `workspace.prepared`, and lists them in its index.

    Shapes that were prepared before from the same files, with the same seed, number of points and version of kinmo, are not
    prepared again. Those at or below the folders of `hold_back` are held back (`store.IndexEntry`). Index and files do not
    depend on `workers`, nor on how often a run was cut off. Of copies of one shape the first that can be read is taken. Raises
    InputError if `root` or what is to be held back is no folder, nothing in `root` is a shape, or another process works in
    the workspace; then the index stays as it was.
    """
    root = Path(root)
    total = _count(root, workspace)
    with workspace.locked():
        store = workspace.prepared
        remove_leftovers(store)
        run = _Run(store, _folders(hold_back))
        jobs = (
            Job(found, store / file_name(found.layout.value, found.id), points, seed) for found in run.choose(root, workspace)
        )
        for job, result in map_unordered(partial(or_crashed, work), jobs, workers):
            name = run.settle(job, result)
            run.done += 1
            on_progress(run.done, total, name)
        for found in run.copies_instead():
            job = Job(found, store / file_name(found.layout.value, found.id), points, seed)
            run.settle(job, or_crashed(work, job))
        write_text_atomically(store / INDEX, index_text(run.entries))
        return run.report()


def _count(root: Path, workspace: Workspace) -> int:
    """How many shapes there are at or below `root`, copies included. Raises InputError if there is none."""
    problems: list[InputError] = []
    total = sum(1 for _ in discover(root, skip=(workspace.path,), report=problems.append))
    if not total and (root / WORKSPACE).is_file():
        raise InputError(root, "is a workspace, which is passed over: expected the folder with the shapes")
    if not total and workspace.path.resolve() in (root.resolve(), *root.resolve().parents):
        raise InputError(root, f"lies in the workspace {workspace.path}, which is passed over: name another --workspace")
    if not total:
        seen = f"; {problems[0]}" if problems else ""
        raise InputError(root, f"expected at least one shape at or below it (docs/formats.md says what is one){seen}")
    return total


@dataclass
class _Run:
    """The state of one run, in the process that writes the files."""

    store: Path
    held_back: tuple[Path, ...] = ()
    entries: list[IndexEntry] = field(default_factory=list)
    left_out: list[Entry] = field(default_factory=list)
    copies: dict[str, list[str]] = field(default_factory=dict)
    others: dict[Path, list[Found]] = field(default_factory=dict)
    """Copies that differ from the first one, by where either is written to."""
    read: dict[Path, Path] = field(default_factory=dict)
    """What was read, by the same."""
    unread: list[Path] = field(default_factory=list)
    made: int = 0
    done: int = 0

    def choose(self, root: Path, workspace: Workspace) -> Iterator[Found]:
        """What is below `root`, without copies."""

        def report(error: InputError) -> None:
            self.left_out.append(Entry("", shown(error.where), (str(error),)))

        first: dict[Path, Path] = {}
        for found in discover(root, skip=(workspace.path,), report=report):
            target = self.store / file_name(found.layout.value, found.id)
            original = first.setdefault(target, found.path)
            if original == found.path:
                yield found
                continue
            self.done += 1
            if not self._is_copy(found, original):
                self.others.setdefault(target, []).append(found)

    def _is_copy(self, found: Found, original: Path) -> bool:
        """Whether a shape has the contents of `original`, beside which it is told of then."""
        is_copy = are_alike(found, replace(found, path=original))
        if is_copy:
            self.copies.setdefault(str(original.absolute()), []).append(f"identical copy left aside: {shown(found.path)}")
        return is_copy

    def copies_instead(self) -> Iterator[Found]:
        """Of every shape that cannot be read one differing copy after another, until one can be; drops what none can be of."""
        while self.unread:
            target = self.unread.pop()
            if copies := self.others.get(target):
                yield copies.pop(0)
            else:
                target.unlink(missing_ok=True)

    def settle(self, job: Job, result: Result | Crashed) -> str:
        """Writes what a worker made. Returns the shape's id."""
        found = job.found
        if isinstance(result, Crashed):  # what may end a process is not tried again in this one
            result = Result(job, problem=str(InputError(shown(found.path), f"cannot be prepared: {result.why}")))
            job.target.unlink(missing_ok=True)
        elif result.entry is None:
            self.unread.append(job.target)
        if result.entry is None:
            self.left_out.append(Entry(found.id, shown(found.path), (result.problem,)))
            return found.id
        self.read[job.target] = found.path
        if result.data is not None:
            write_bytes_atomically(job.target, result.data)
            self.made += 1
        is_held_back = any(found.path.resolve().is_relative_to(folder) for folder in self.held_back)
        self.entries.append(replace(result.entry, is_held_back=is_held_back))
        return found.id

    def report(self) -> PrepareReport:
        for target, others in self.others.items():
            read = self.read.get(target)
            what_of_it = "which cannot be prepared" if read is None else f"which is read instead: {shown(read)}"
            for found in others:
                if read is None or not self._is_copy(found, read):
                    reason = f"differs from another copy of {found.id}, {what_of_it}"
                    self.left_out.append(Entry(found.id, shown(found.path), (reason,)))
        report = PrepareReport(left_out=sorted(self.left_out, key=lambda entry: (entry.path, entry.id)), made=self.made)
        for entry in sorted(self.entries, key=lambda entry: entry.source):
            copies = tuple(self.copies.get(entry.source, ()))
            row = Entry(entry.id, shown(entry.source), entry.repairs + copies)
            (report.repaired if entry.repairs else report.taken).append(row)
        return report


def _folders(paths: Sequence[Path]) -> tuple[Path, ...]:
    """The folders without links. Raises InputError for what is none."""
    for path in paths:
        if not path.is_dir():
            raise InputError(path, "expected a folder with shapes to hold back", "--hold-back")
    return tuple(path.resolve() for path in paths)


def work(job: Job) -> Result:
    """Reads and prepares one shape. What is wrong with the shape becomes the result's `problem`."""
    try:
        if job.found.layout is Layout.PARTNET_MOBILITY:
            check_annotated(job.found.path)
        made_from = {
            "files": fingerprint(job.found),
            "points": job.points,
            "seed": job.seed,
            "kinmo": __version__,
            "format": FORMAT,
        }
        source = str(job.found.path.absolute())
        known = _known(job.target)
        if known is not None and known["made_from"] == digest(made_from) and known["entry"]["source"] == source:
            return Result(job, IndexEntry(**{**known["entry"], "repairs": tuple(known["entry"]["repairs"])}))
        shape = read_found(job.found)
        prepared = prepare_shape(shape, points=job.points, seed=job.seed)
    except InputError as error:
        return Result(job, problem=str(error))
    entry = IndexEntry(
        id=shape.id,
        layout=shape.layout,
        category=shape.category,
        file=file_name(shape.layout, shape.id),
        source=source,
        partnet_id=shape.partnet_id,
        geometry_hash=prepared.geometry_hash,
        part_count=len(shape.parts),
        leaf_count=len(shape.leaves),
        joint_count=0 if shape.mobility is None else sum(1 for _ in shape.mobility.movable()),
        is_labelled=shape.mobility is not None,
        repairs=shape.repairs,
    )
    return Result(job, entry, to_bytes(prepared, {"made_from": digest(made_from), "entry": asdict(entry)}))


def _known(target: Path) -> dict[str, Any] | None:
    """The provenance of the file that is there already."""
    try:
        provenance: dict[str, Any] = read_header(target)["provenance"]
    except InputError:
        return None
    return provenance
