"""What was decided of the shapes that have no joints, and the report of it. Nothing here needs torch."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from kinmo.core.names import name_on_disk
from kinmo.dataset.store import IndexEntry
from kinmo.dataset.workspace import Workspace
from kinmo.io.atomic_files import write_text_atomically
from kinmo.io.readers import Layout
from kinmo.pipeline.label_acceptance import STEPS, JudgedJoint, Judgement, Tally, tally, tally_types

LABELS = "mobility_v2.json"
"""What a folder with a pseudo label has."""
DECISIONS = "decisions"
"""A file a shape, accepted or not, written when all else of the shape is: what was decided, and from what."""


def folder_name(entry: IndexEntry) -> str:
    """A folder's name: the id, and for what is not PartNet's, which may have the same ids, the layout after a sign of no id."""
    name = name_on_disk(entry.id)
    return name if entry.layout == Layout.PARTNET.value else f"{name}@{entry.layout}"


def decision_path(workspace: Workspace, entry: IndexEntry) -> Path:
    """Where the decision on a shape is written."""
    return workspace.pseudo / DECISIONS / f"{folder_name(entry)}.json"


@dataclass(frozen=True)
class Decision:
    """What was decided of a shape, by which threshold; `made_from` is a hash of all that it depends on."""

    judgement: Judgement
    made_from: str
    threshold: float


def write_decision(path: Path, decision: Decision) -> None:
    """Write what was decided of a shape."""
    write_text_atomically(path, json.dumps(asdict(decision), ensure_ascii=False) + "\n")


def read_decision(path: Path) -> Decision | None:
    """What was decided of a shape; None if nothing was."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        judgement = data["judgement"]
        joints = tuple(JudgedJoint(**joint) for joint in judgement["joints"])
        return Decision(**{**data, "judgement": Judgement(**{**judgement, "joints": joints})})
    except (OSError, ValueError, KeyError, TypeError):
        return None


def acceptance(decisions: Sequence[Decision], method: str, copies: int, outdated: Sequence[str] = ()) -> dict[str, Any]:
    """The acceptance report, of decisions by a method, as plain data.

    `outdated` are categories whose labels are of before: by other networks, say. It has `text`, `tables` (as
    `kinmo.view.report_page.Table` takes them) and every refusal.
    """
    judgements = [decision.judgement for decision in decisions]
    ways = sorted({f"all joints above {decision.threshold:g}, by {method}" for decision in decisions})
    whole = tally(judgements)
    categories = sorted({judgement.category for judgement in judgements})
    by_category = {name: tally(j for j in judgements if j.category == name) for name in categories} | {"all": whole}
    reasons: dict[str, list[str]] = {}
    for judgement in judgements:
        if not judgement.is_accepted:
            reasons.setdefault(judgement.refusal, []).append(judgement.shape_id)
    text = (
        f"{whole.accepted} of {whole.shapes} shapes were accepted ({'; or '.join(ways) or 'there are none'}), with "
        f"{whole.accepted_joints} of {whole.joints} joints; {copies} copies of labelled shapes were left alone."
    )
    if outdated:
        text += f" Those of {', '.join(outdated)} would be labelled otherwise now: kinmo pseudo-label brings them up to date."
    return {
        "text": text,
        "ways": ways,
        "copies": copies,
        "tables": [
            _counts("Pseudo labels by category", "category", by_category),
            _counts("Pseudo labels by motion type", "type", tally_types(judgements)),
            {
                "caption": "Refused",
                "header": ["reason", "shapes", "for example"],
                "rows": [
                    [reason, str(len(ids)), ids[0]] for reason, ids in sorted(reasons.items(), key=lambda item: -len(item[1]))
                ],
            },
        ],
        "refused": dict(sorted(reasons.items())),
    }


def _counts(caption: str, what: str, groups: Any) -> dict[str, Any]:
    header = [what, "shapes", "accepted", "joints", "accepted joints", *(f"> {step:g}" for step in STEPS)]

    def row(name: str, group: Tally) -> list[str]:
        counts = (group.shapes, group.accepted, group.joints, group.accepted_joints, *group.at_least)
        return [name, *map(str, counts)]

    note = "The columns on the right count joints that score more."
    return {"caption": caption, "header": header, "rows": [row(name, group) for name, group in groups.items()], "note": note}
