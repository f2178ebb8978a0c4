"""Agreement of `kinmo eval FILES` with an independent scorer of URDF files.

Both score the same URDFs, and every figure that both have is compared. The scorer is a Python file that is called as
`SCORER TRUTH PREDICTIONS --json OUT` and writes micro and macro figures under the same keys as kinmo.

Usage:
    python bench/referee_agreement.py --referee SCORER --truth DIR [--workers 1] [--quick] PREDICTIONS
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from common import Cell, option_parser, print_claims, print_table
from kinmo.evaluation.aggregate import Unit
from kinmo.evaluation.urdf_scoring import score_urdf_folder, summarise_urdf_scores
from kinmo.evaluation.urdf_scoring.urdf_figures import FIGURES, MEDIANS

QUICK = 20
TOLERANCE = {Unit.SHARE: 0.01, Unit.DEGREES: 0.1, Unit.DIAGONALS: 0.001}
"""Largest difference by unit, since both sample surfaces. Counts must be equal."""
UNITS = {figure.key: figure.unit for figure in FIGURES} | {"angle_median": Unit.DEGREES, "line_median": Unit.DIAGONALS}


def referee_figures(scorer: Path, truth: Path, predictions: Path, ids: list[str], workers: int) -> dict[str, Any]:
    """Figures of the other scorer for the same objects."""
    with tempfile.TemporaryDirectory() as folder:
        names, result = Path(folder) / "ids.txt", Path(folder) / "result.json"
        names.write_text("\n".join(ids))
        command = [sys.executable, scorer, truth, predictions, "--json", result, "--ids", names, "--jobs", str(workers)]
        subprocess.run(list(map(str, command)), check=True, stdout=subprocess.DEVNULL)
        return dict(json.loads(result.read_text()))


def common_figures(ours: dict[str, Any], theirs: dict[str, Any]) -> list[tuple[str, float | None, float | None]]:
    """Name, our value and their value of every figure that both have."""
    rows: list[tuple[str, float | None, float | None]] = []
    for key in ("objects", "scored", "failed", "missing", "parts", "found", "false_positives", *dict(MEDIANS)):
        rows.append((f"micro {key}", ours["micro"][key], theirs["micro"][key]))
    for figure in (figure for figure in FIGURES if figure.key in theirs["micro"]):
        mine, other = ours["micro"][figure.key], theirs["micro"][figure.key]
        rows.append((f"micro {figure.key}", mine and mine["value"], other))
        mine, other = ours["macro"][figure.key], theirs["macro"].get(figure.key)
        rows.append((f"macro {figure.key}", mine and mine["value"], other and other["mean"]))
    return rows


def agree(name: str, mine: float | None, other: float | None) -> bool:
    """True if two values are equal within the tolerance of their unit."""
    if mine is None or other is None:
        return mine is other
    unit = UNITS.get(name.split()[1])
    return abs(mine - other) <= (0 if unit is None else TOLERANCE[unit])


def main() -> int:
    """Run both, and print the figures side by side."""
    parser = option_parser(__doc__, f"the first {QUICK} objects only")
    parser.add_argument("predictions", type=Path, help="folder of URDF files")
    parser.add_argument("--truth", type=Path, required=True, help="folder of the annotated objects")
    parser.add_argument("--referee", type=Path, required=True, help="Python file of the other scorer")
    parser.add_argument("--workers", type=int, default=1, help="number of processes")
    args = parser.parse_args()
    ids = sorted(file.parent.name for file in args.truth.glob("*/mobility_v2.json"))[: QUICK if args.quick else None]
    report = score_urdf_folder(args.predictions, args.truth, ids=ids, workers=args.workers)
    theirs = referee_figures(args.referee, args.truth, args.predictions, ids, args.workers)
    rows = common_figures(summarise_urdf_scores(report), theirs)
    lines: list[tuple[Cell, ...]] = []
    for name, mine, other in rows:
        difference = None if mine is None or other is None else mine - other
        lines.append((name, mine, other, difference, "" if agree(name, mine, other) else "differs"))
    print_table(("figure", "kinmo", "referee", "difference", ""), lines)
    agreeing, total = sum(agree(*row) for row in rows), len(rows)
    claim = "figures of kinmo eval that agree with an independent scorer"
    print_claims(
        {"claim": claim, "ours": agreeing, "peer": total, "ratio": agreeing / total, "goal": 1.0, "met": agreeing == total}
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
