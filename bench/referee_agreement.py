"""Do `kinmo eval FILES` and an independent scorer tell the same story?

Runs both on the same URDFs and compares every figure. The scorer is a Python file that is called as
`SCORER TRUTH PREDICTIONS --json OUT` and writes micro and macro figures under the keys that kinmo uses.

    python bench/referee_agreement.py --referee SCORER --truth DIR PREDICTIONS
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from kinmo.evaluation.aggregate import Unit
from kinmo.evaluation.urdf_scoring import score_files, summarise
from kinmo.evaluation.urdf_scoring.urdf_figures import FIGURES, MEDIANS

QUICK = 20
TOLERANCE = {Unit.SHARE: 0.01, Unit.DEGREES: 0.1, Unit.DIAGONALS: 0.001}
UNITS = {figure.key: figure.unit for figure in FIGURES} | {"angle_median": Unit.DEGREES, "line_median": Unit.DIAGONALS}


def referee_figures(scorer: Path, truth: Path, predictions: Path, ids: list[str], workers: int) -> dict[str, Any]:
    """What the other scorer says of the same objects."""
    with tempfile.TemporaryDirectory() as folder:
        names, result = Path(folder) / "ids.txt", Path(folder) / "result.json"
        names.write_text("\n".join(ids))
        command = [sys.executable, scorer, truth, predictions, "--json", result, "--ids", names, "--jobs", str(workers)]
        subprocess.run(list(map(str, command)), check=True, stdout=subprocess.DEVNULL)
        return dict(json.loads(result.read_text()))


def compared(ours: dict[str, Any], theirs: dict[str, Any]) -> list[tuple[str, float | None, float | None]]:
    """Name, our value and theirs of every figure that both know."""
    rows: list[tuple[str, float | None, float | None]] = []
    for key in ("objects", "scored", "failed", "missing", "parts", "found", "false_positives", *dict(MEDIANS)):
        rows.append((f"micro {key}", ours["micro"][key], theirs["micro"][key]))
    for figure in FIGURES:
        mine, other = ours["micro"][figure.key], theirs["micro"][figure.key]
        rows.append((f"micro {figure.key}", mine and mine["value"], other))
        mine, other = ours["macro"][figure.key], theirs["macro"].get(figure.key)
        rows.append((f"macro {figure.key}", mine and mine["value"], other and other["mean"]))
    return rows


def agree(name: str, mine: float | None, other: float | None) -> bool:
    """Whether two values are the same within what sampling may change."""
    if mine is None or other is None:
        return mine is other
    unit = UNITS.get(name.split()[1])
    return abs(mine - other) <= (0 if unit is None else TOLERANCE[unit])


def main() -> int:
    """Run both, print the figures side by side."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("predictions", type=Path)
    parser.add_argument("--truth", type=Path, required=True)
    parser.add_argument("--referee", type=Path, required=True)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--quick", action="store_true", help=f"the first {QUICK} objects only")
    args = parser.parse_args()
    ids = sorted(file.parent.name for file in args.truth.glob("*/mobility_v2.json"))[: QUICK if args.quick else None]
    report = score_files(args.predictions, args.truth, ids=ids, workers=args.workers)
    rows = compared(summarise(report), referee_figures(args.referee, args.truth, args.predictions, ids, args.workers))
    print(f"{'figure':24}{'kinmo':>12}{'referee':>12}{'difference':>12}")
    for name, mine, other in rows:
        values = "".join(f"{'-' if value is None else f'{value:.5g}':>12}" for value in (mine, other))
        difference = "" if mine is None or other is None else f"{mine - other:+.2g}"
        print(f"{name:24}{values}{difference:>12}{'' if agree(name, mine, other) else '  <- differs'}")
    differing = sum(not agree(*row) for row in rows)
    claim = {"claim": "kinmo eval agrees with an independent scorer", "ours": len(rows) - differing, "peer": len(rows)}
    print(json.dumps({**claim, "ratio": (len(rows) - differing) / len(rows), "goal": 1.0, "met": differing == 0}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
