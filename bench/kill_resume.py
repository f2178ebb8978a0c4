"""Does a kinmo command that is killed at a random moment, and then typed again, end with the same files as an undisturbed one?

    python bench/kill_resume.py [--kills 20] [--from WORKSPACE] [--ignore GLOB] [-- kinmo COMMAND ... --workspace {workspace}]

The command runs once undisturbed, into a copy of the workspace given by --from (or into none). Then, for every trial, it
starts in a fresh copy, gets SIGKILL (with all its children) at a random moment of its life, and runs again to its end. All
files of the two workspaces are compared byte by byte. At last the command runs once more, and may not touch a file. Without
a command, `kinmo prepare` runs on procedural shapes.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path

from kinmo.synth.generate import generate

PLACE = "{workspace}"
JOURNAL = "journal*"
"""Says when stages ran and how long they took, and so is never the same."""


@dataclass(frozen=True)
class Trial:
    """What came of one kill. `died` is False where the command had finished before."""

    after: float
    died: bool
    differing: tuple[str, ...]
    repeated: tuple[str, ...]


@dataclass(frozen=True)
class Experiment:
    """A command with a place for the workspace, the workspace it starts from, and the files that do not count."""

    command: tuple[str, ...]
    start: Path | None
    ignored: tuple[str, ...]

    def fresh(self, workspace: Path) -> Path:
        """A workspace to start in."""
        shutil.rmtree(workspace, ignore_errors=True)
        if self.start is not None:
            shutil.copytree(self.start, workspace, symlinks=True)
        return workspace

    def launch(self, workspace: Path) -> subprocess.Popen[bytes]:
        """The running command, in a process group of its own."""
        arguments = [argument.replace(PLACE, str(workspace)) for argument in self.command]
        return subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True)

    def run(self, workspace: Path) -> float:
        """Runs the command to its end; its seconds. Ends the bench if it fails."""
        begin = time.monotonic()
        process = self.launch(workspace)
        try:
            _, errors = process.communicate()
        except BaseException:
            os.killpg(process.pid, signal.SIGKILL)
            raise
        if process.returncode != 0:
            raise SystemExit(f"{' '.join(self.command)} failed:\n{errors.decode(errors='replace')}")
        return time.monotonic() - begin

    def files(self, workspace: Path) -> dict[str, bytes]:
        """The contents of all files that count."""
        paths = {path.relative_to(workspace).as_posix(): path for path in workspace.rglob("*") if path.is_file()}
        return {
            name: path.read_bytes()
            for name, path in sorted(paths.items())
            if not any(fnmatch(part, glob) for glob in self.ignored for part in name.split("/"))
        }

    def times(self, workspace: Path) -> dict[str, int]:
        """When each of these files changed."""
        return {name: (workspace / name).stat().st_mtime_ns for name in self.files(workspace)}

    def trial(self, workspace: Path, whole: dict[str, bytes], after: float) -> Trial:
        """Kill after some seconds, run again, compare."""
        process = self.launch(self.fresh(workspace))
        try:
            process.communicate(timeout=after)
            died = False
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
            died = True
        self.run(workspace)
        found = self.files(workspace)
        differing = tuple(name for name in sorted({*whole, *found}) if whole.get(name) != found.get(name))
        before = self.times(workspace)
        self.run(workspace)
        after_all = self.times(workspace)
        repeated = tuple(name for name in sorted({*before, *after_all}) if before.get(name) != after_all.get(name))
        return Trial(after, died, differing, repeated)


def default_command(folder: Path, quick: bool) -> tuple[str, ...]:
    """`kinmo prepare` on procedural shapes in all layouts."""
    generate(folder / "shapes", count=1 if quick else 2)
    return ("kinmo", "prepare", str(folder / "shapes"), "--workspace", PLACE)


def main() -> int:
    """Run all trials and print what differed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--from", dest="start", type=Path, help="workspace to start from")
    parser.add_argument(
        "--ignore", action="append", default=[JOURNAL, ".lock"], metavar="GLOB", help="names of files that may differ"
    )
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--quick", action="store_true", help="three kills")
    parser.add_argument("command", nargs="*", help=f"with {PLACE} where the workspace goes")
    args = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    kills = 3 if args.quick else args.kills
    rng = random.Random(args.seed)
    with tempfile.TemporaryDirectory(prefix="kill-resume-") as name:
        folder = Path(name)
        command = tuple(args.command) or default_command(folder, args.quick)
        if not any(PLACE in argument for argument in command):
            parser.error(f"the command must name its workspace as {PLACE}")
        command = (str(Path(sys.executable).parent / "kinmo"), *command[1:]) if command[0] == "kinmo" else command
        experiment = Experiment(command, args.start, tuple(args.ignore))
        workspace = folder / "workspace"
        seconds = experiment.run(experiment.fresh(workspace))
        whole = experiment.files(workspace)
        print(f"undisturbed: {seconds:.1f} s, {len(whole)} files")
        trials = []
        for number in range(kills):
            trial = experiment.trial(workspace, whole, rng.uniform(0.0, seconds))
            trials.append(trial)
            wrong = [*(f"differs: {path}" for path in trial.differing), *(f"made again: {path}" for path in trial.repeated)]
            state = "killed" if trial.died else "over"
            print(f"{number + 1:3}  {state} after {trial.after:6.2f} s  {'; '.join(wrong) or 'same files'}", flush=True)
    good = sum(not trial.differing and not trial.repeated for trial in trials)
    dead = sum(trial.died for trial in trials)
    what = " ".join(["kinmo", *command[1:2]])
    claim = {"claim": f"{what}: same files after kill -9 at {dead} random moments", "ours": good, "peer": kills}
    print(json.dumps({**claim, "ratio": good / kills, "goal": 1.0, "met": good == kills}))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
