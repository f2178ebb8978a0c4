"""Results of kinmo commands that are killed at random moments and started again, compared with undisturbed ones.

Without a command, every stage (or those named) runs on a workspace of few procedural shapes with few epochs. A command runs
once undisturbed in a copy of the workspace of the stages before it. For every trial it starts in a fresh copy, gets SIGKILL
with all its children at a random moment, and runs again to its end. The trial is good if:

1. All files are the same, byte by byte. The journal, the lock and the order of cache lines do not count.
2. No finished file is written again: records of stages, prepared shapes, labels, predictions.
3. Training continues after the last complete epoch.
4. A last run of the command touches no file.

Processes are forked from one that has imported kinmo, so kills hit the work and not the imports.

Usage:
    python bench/kill_resume.py [--kills 20] [--quick] [STAGE ...]
    python bench/kill_resume.py --from WORKSPACE -- kinmo COMMAND ... --workspace {workspace}
"""

from __future__ import annotations

import json
import multiprocessing
import os
import random
import re
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from fnmatch import fnmatch
from importlib.resources import files
from itertools import pairwise
from pathlib import Path

from common import option_parser, print_claims, print_table

PLACE = "{workspace}"
IGNORED = ("journal*", ".lock", ".kinmo.jsonl")
FINISHED = (
    "prepared/*/*",
    "pseudo_labels/*/*/*",
    "evaluation/shape_scores/*",
    "scans/*/*/*.*",
    "out/*/*",
    "shapes/*/*/*",
)
"""Files that may not be written again once they are whole. Weights count too, once the workspace records their training."""
RECORDS = ".kinmo.jsonl"
FAMILIES = ("laptop", "stapler")
FORK = multiprocessing.get_context("forkserver")
FORK.set_forkserver_preload(
    [
        "kinmo.cli",
        "kinmo.view.html_report",
        "kinmo.pipeline.predict_shapes",
        "kinmo.pipeline.pseudo_label_shapes",
        "kinmo.experiments.scan_tables.make_table",
    ]
)

SYNTH = ("synth", *(word for name in FAMILIES for word in ("--family", name)), "--oracle", "--workers", "2", "--count")
STAGES: dict[str, tuple[str, ...]] = {
    "synth": (*SYNTH, "5", f"{PLACE}/shapes"),
    "prepare": ("prepare", "{shapes}", "--oracle", "{shapes}/oracle", "--workers", "2"),
    "train gnn": ("train", "gnn", "--config", "{config}"),
    "train axis": ("train", "axis", "--config", "{config}"),
    "pseudo-label": ("pseudo-label", "--threshold", "0"),
    "render": ("render", "--config", "{config}", "--category", "laptop"),
    "train ancsh": ("train", "ancsh", "--config", "{config}", "--category", "laptop"),
    "eval": ("eval",),
    "report": ("report",),
    "predict": ("predict", "{shapes}/partnet", "--out", f"{PLACE}/out"),
    "table": ("table", "2", "--config", "{config}", "--category", "laptop", "--seeds", "1"),
    "train all": ("train", "all", "--config", "{config}", "--category", "laptop"),
}
"""Commands of the stages, in order. `train axis` trains the axis selection and the ranking."""
AFTER = {stage: before for before, stage in pairwise(STAGES)} | {"train all": "prepare"}
"""The stage whose workspace a stage starts from."""


@dataclass(frozen=True)
class Trial:
    """The outcome of one kill: the number of finished files, which must be `kept`, and what is `wrong`."""

    kept: int
    wrong: tuple[str, ...]


@dataclass(frozen=True)
class Experiment:
    """A command with a placeholder for the workspace, and the workspace that it starts from."""

    command: tuple[str, ...]
    start: Path | None
    workspace: Path

    def fresh(self) -> None:
        """Make a copy of the workspace to start from."""
        shutil.rmtree(self.workspace, ignore_errors=True)
        if self.start is not None:
            shutil.copytree(self.start, self.workspace, symlinks=True)

    @property
    def log(self) -> Path:
        """File of the last run's stderr."""
        return self.workspace.with_suffix(".log")

    def launch(self) -> multiprocessing.process.BaseProcess:
        """Start the command in a process group of its own."""
        arguments = [argument.replace(PLACE, str(self.workspace)) for argument in self.command]
        process = FORK.Process(target=_kinmo, args=(arguments, self.log))
        process.start()
        return process

    def run(self) -> float:
        """Run the command to its end, and return the seconds. Exits if it fails."""
        begin = time.monotonic()
        process = self.launch()
        try:
            process.join()
        except BaseException:
            _kill(process)
            raise
        if process.exitcode:
            raise SystemExit(f"kinmo {' '.join(self.command)} failed:\n{self.log.read_text(errors='replace')}")
        return time.monotonic() - begin

    def files(self) -> dict[str, tuple[bytes, int]]:
        """Contents and modification times in ns of all files that count."""
        paths = {path.relative_to(self.workspace).as_posix(): path for path in self.workspace.rglob("*") if path.is_file()}
        return {
            name: (path.read_bytes(), path.stat().st_mtime_ns)
            for name, path in sorted(paths.items())
            if not any(fnmatch(part, glob) for glob in IGNORED for part in name.split("/"))
        }

    def trial(self, whole: dict[str, tuple[bytes, int]], after: float, again: bool) -> Trial | None:
        """Kill the command after some seconds, run it again and compare the files.

        With `again`, run it once more and compare the modification times. Returns None if the command ended before the kill.
        """
        self.fresh()
        begun = time.time_ns()
        process = self.launch()
        process.join(after)
        if not process.is_alive():
            return None
        _kill(process)
        killed, epochs, trained = self.files(), self._epochs(), self._trained()
        self.run()
        ended = self.files()
        wrong = [f"differs: {name}" for name in sorted({*whole, *ended}) if not _same(whole, ended, name)]
        done = [name for name, (_, when) in killed.items() if when > begun and (name in trained or _is_finished(name))]
        wrong += [f"made again: {name}" for name in done if killed[name] != ended.get(name)]
        wrong += [f"epochs trained again: {what}" for what in self._repeated(epochs)]
        if again:
            self.run()
            wrong += [f"touched at last: {name}" for name, found in self.files().items() if found != ended.get(name)]
        return Trial(len(done), tuple(wrong))

    def _trained(self) -> set[str]:
        """Weights whose training the workspace records as finished."""
        path = self.workspace / RECORDS
        records = path.read_text(encoding="utf-8") if path.exists() else ""
        return set(re.findall(r'"(models/[^"]+/weights\.[a-z]+)"', records))

    def _epochs(self) -> dict[str, int]:
        """Complete epochs by name of the network."""
        tables = self.workspace.rglob("metrics.json")
        return {
            _network(path.parent.relative_to(self.workspace).as_posix()): len(json.loads(path.read_text(encoding="utf-8")))
            for path in tables
        }

    def _repeated(self, before: dict[str, int]) -> Iterator[str]:
        """Networks for which the last run trained an epoch that was complete before."""
        for name, first in re.findall(r"^training (.+): (\d+)/", self.log.read_text(encoding="utf-8"), re.MULTILINE):
            if int(first) <= before.get(name, 0):
                yield f"{name}, {first} of {before[name]}"


def _same(one: dict[str, tuple[bytes, int]], other: dict[str, tuple[bytes, int]], name: str) -> bool:
    return name in one and name in other and one[name][0] == other[name][0]


def _is_finished(name: str) -> bool:
    """True if a file may not be written again."""
    is_draft = any(part.startswith(".") and part.endswith("~") for part in name.split("/"))
    return not is_draft and any(fnmatch(name, glob) for glob in FINISHED)


def _network(folder: str) -> str:
    """Name that training prints for the network in a folder of the workspace."""
    _, name, *cell = folder.split("/")
    if not cell:
        return name
    category, labels, seed, network = cell
    setting = labels.removesuffix("-kinmo").removesuffix("-paper")
    return f"{network} ({category}, {setting}, seed {seed}{', labels by paper' if labels.endswith('-paper') else ''})"


def _kinmo(arguments: list[str], log: Path) -> None:
    """Run the program `kinmo` with these arguments in this process."""
    os.setsid()
    sys.argv[:] = ["kinmo", *arguments]
    for stream, path in ((1, Path(os.devnull)), (2, log)):
        handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)
        os.dup2(handle, stream)
    from kinmo.cli import main

    main()


def _kill(process: multiprocessing.process.BaseProcess) -> None:
    """Kill a command and all its children at once."""
    if process.pid is not None and process.is_alive():
        try:
            os.killpg(process.pid, signal.SIGKILL)
        except ProcessLookupError:  # not yet the leader of a group
            process.kill()
    process.join()


def tiny_config(folder: Path) -> Path:
    """A configuration far smaller than `small`, whose networks label every shape, however unsure."""
    text = (files("kinmo.config") / "builtin" / "small.toml").read_text(encoding="utf-8")
    few = {"epochs": 4, "batches_per_epoch": 4, "points": 64, "members": 2, "states": 3, "views": 4}
    for key, value in few.items():
        text = re.sub(rf"^{key} = \d+", f"{key} = {value}", text, flags=re.MULTILINE)
    # enough to find all parts of some scans, which self-training needs
    text = re.sub(r"(\nbatch_frames = )\d+(\nbatches_per_epoch = )\d+", r"\g<1>8\g<2>24", text)
    text = text.replace("[ancsh]\n", "[ancsh]\nconfidence = 0.0\n")
    text += "\n[refinement]\nthreshold = 0.0\nchance = 0.0\ndoubt = 1.0\n"
    for section in ("[gnn.training]", "[ranking.training]"):  # fewer epochs label no laptop with the usual structure
        text = text.replace(f"{section}\nepochs = 4\n", f"{section}\nepochs = 16\n")
    path = folder / "tiny.toml"
    path.write_text(text, encoding="utf-8")
    return path


def stage_command(name: str, folder: Path) -> tuple[str, ...]:
    """The command of a stage, with a placeholder for the workspace."""
    places = {"{shapes}": str(folder / "shapes"), "{config}": str(tiny_config(folder))}
    words = STAGES[name]
    for place, path in places.items():
        words = tuple(word.replace(place, path) for word in words)
    return (*words, "--workspace", PLACE, "--device", "cpu")


def examine(what: str, experiment: Experiment, kills: int, rng: random.Random) -> int:
    """Run all trials of one command, and return the number of good ones. The last workspace is complete."""
    experiment.fresh()
    seconds = experiment.run()
    whole = experiment.files()
    idle = experiment.run()
    touched = [name for name, found in experiment.files().items() if found != whole.get(name)]
    print(f"{what}: undisturbed {seconds:.1f} s, {len(whole)} files", *(f"touched: {name}" for name in touched), flush=True)
    good = 0
    for number in range(1, kills + 1):
        trial = None
        while trial is None:  # the machine may be faster than in the undisturbed run
            after = rng.uniform(0.5 * min(idle, seconds), seconds)
            trial = experiment.trial(whole, after, again=number == kills)
            seconds = after if trial is None else seconds
        good += not trial.wrong and not touched
        found = "; ".join(trial.wrong) or "same files"
        print(f"  {number:3}  killed after {after:6.2f} s, {trial.kept} files finished: {found}", flush=True)
    print(f"{what}: {good} of {kills} with the same files", flush=True)
    return good


def main() -> int:
    """Run all trials, and print what differed."""
    parser = option_parser(__doc__, "two kills")
    parser.add_argument("--kills", type=int, default=20, help="kills of every command")
    parser.add_argument("--from", dest="start", type=Path, help="workspace that the command starts from")
    parser.add_argument("--seed", type=int, default=0, help="seed of the random moments")
    parser.add_argument("command", nargs="*", metavar="STAGE", help=f"some of {', '.join(STAGES)}; or kinmo and a command")
    args = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    os.environ |= {"OMP_NUM_THREADS": "1", "RAYON_NUM_THREADS": "1"}
    warm = FORK.Process(target=os.getpid)  # the first process waits for the imports
    warm.start()
    warm.join()
    kills, rng = 2 if args.quick else args.kills, random.Random(args.seed)
    good: dict[str, int] = {}
    with tempfile.TemporaryDirectory(prefix="kill-resume-") as name:
        folder = Path(name)
        workspace = folder / "workspace"
        if args.command[:1] == ["kinmo"]:
            if not any(PLACE in argument for argument in args.command):
                parser.error(f"the command must name its workspace as {PLACE}")
            experiment = Experiment(tuple(args.command[1:]), args.start, workspace)
            good[" ".join(args.command[:2])] = examine(args.command[1], experiment, kills, rng)
        else:
            if unknown := set(args.command) - STAGES.keys():
                parser.error(f"expected stages of {', '.join(STAGES)}, got {', '.join(sorted(unknown))}")
            wanted = args.command or list(STAGES)
            needed = set(wanted)
            for stage in reversed(STAGES):
                needed |= {AFTER[stage]} if stage in needed and stage in AFTER else set()
            left: dict[str, Path] = {}
            for stage in filter(needed.__contains__, STAGES):
                experiment = Experiment(stage_command(stage, folder), left.get(AFTER.get(stage, "")), workspace)
                if stage in wanted:
                    good[stage] = examine(stage, experiment, kills, rng)
                experiment.fresh()
                experiment.run()
                if stage == "synth":
                    (workspace / "shapes").rename(folder / "shapes")
                else:
                    left[stage] = workspace.rename(folder / stage)
    total, well = kills * len(good), sum(good.values())
    claim = {"claim": f"same files after kill -9 at random moments of {', '.join(good)}", "ours": well, "peer": total}
    rows = [(stage, kills, count) for stage, count in good.items()]
    print_table(("command", "kills", "same files"), rows)
    print_claims({**claim, "ratio": well / total, "goal": 1.0, "met": well == total})
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
