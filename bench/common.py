"""Helpers of the benchmark scripts: options, timing, tables and the last line of output.

`use_one_thread` must run before NumPy is imported, so this module imports nothing but the standard library.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
REAL_OBJECTS = ROOT / "data" / "partnet"
"""Default folder of the real objects (PartNet-Mobility), which are not part of this repository."""
CACHE = ROOT / "workspace" / "bench"
"""Default folder of what is made once and used again: procedural shapes, prepared shapes and trained networks."""

Cell = str | float | int | None
Claim = dict[str, Any]


def use_one_thread() -> None:
    """Limit kinmo's core, NumPy and torch to one thread. Call it before they are imported."""
    for variable in ("RAYON_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[variable] = "1"


def option_parser(description: str | None, quick: str) -> argparse.ArgumentParser:
    """A parser with the option --quick; `quick` says what that does."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help=quick)
    return parser


def has_real_objects(folder: Path) -> bool:
    """True if a folder of real objects exists; else prints where they come from."""
    if not folder.exists():
        print(f"No real objects at {folder}. See docs/guide/data.md for their source, or name a folder with --data.")
    return folder.exists()


def best_time(run: Callable[[], object], repeats: int) -> float:
    """Least processor time of several runs, in seconds."""
    return best_times([run], repeats)[0]


def best_times(runs: Sequence[Callable[[], object]], rounds: int) -> list[float]:
    """Least processor times of several functions that run in turns, in seconds."""
    times: list[list[float]] = [[] for _ in runs]
    for _ in range(rounds):
        for run, own in zip(runs, times, strict=True):
            start = time.process_time()
            run()
            own.append(time.process_time() - start)
    return [min(own) for own in times]


def print_table(head: Sequence[str], rows: Sequence[Sequence[Cell]]) -> None:
    """Print aligned columns: text to the left, numbers to the right with four significant digits."""
    texts = [[_text(cell) for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(head, *texts, strict=True)]
    is_text = [any(isinstance(row[index], str) for row in rows) for index in range(len(head))]
    for cells in (head, *texts):
        padded = (
            cell.ljust(width) if left else cell.rjust(width) for cell, width, left in zip(cells, widths, is_text, strict=True)
        )
        print("  ".join(padded).rstrip(), flush=True)


def _text(cell: Cell) -> str:
    if cell is None:
        return "-"
    return f"{cell:.4g}" if isinstance(cell, float) else str(cell)


def ratio_claim(claim: str, *, ours: float, peer: float, goal: float | None, agree: bool = True) -> Claim:
    """A claim that kinmo takes `peer / ours` times less time than another library. It needs results that agree."""
    ratio = peer / ours
    met = None if goal is None else ratio >= goal and agree
    return {"claim": claim, "ours": ours, "peer": peer, "ratio": ratio, "goal": goal, "met": met}


def budget_claim(claim: str, ours: float, budget: float) -> Claim:
    """A claim that kinmo stays below a budget of time or memory."""
    return {"claim": claim, "ours": ours, "peer": None, "ratio": budget / ours, "goal": budget, "met": ours <= budget}


def rate_claim(claim: str, ours: float, goal: float) -> Claim:
    """A claim that kinmo reaches a rate."""
    return {"claim": claim, "ours": ours, "peer": None, "ratio": ours / goal, "goal": goal, "met": ours >= goal}


def print_claims(*claims: Claim) -> None:
    """Print the last line of a script: the first claim as JSON, the others under `more`. `met` is true if all are met."""
    first, *more = claims
    met = [claim["met"] for claim in claims if claim["met"] is not None]
    line = {**first, "met": all(met) if met else None}
    print(json.dumps(line | ({"more": more} if more else {})))
