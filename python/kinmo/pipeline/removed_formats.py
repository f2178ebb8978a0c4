"""Files of earlier predictions in formats that are not written again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from kinmo.core.wording import clean_text
from kinmo.io.result_folder import options_in

MAX_LISTED_FILES = 6
"""Largest number of files that the line names."""


@dataclass(frozen=True)
class EarlierResult:
    """A result before it is predicted again.

    Attributes:
        formats: its formats.
        files: names of the files in its folder, without those in subfolders.
    """

    formats: tuple[str, ...]
    files: tuple[str, ...]

    @staticmethod
    def of(folder: Path) -> EarlierResult:
        """The result in a folder. One without formats if there is none."""
        formats = options_in(folder).formats
        files = sorted(path.name for path in folder.iterdir() if path.is_file()) if formats else []
        return EarlierResult(formats, tuple(files))


def removed_line(earlier: Mapping[Path, EarlierResult], formats: Sequence[str]) -> str | None:
    """A line that names the removed files of formats that were not written again. None if there are none.

    Args:
        earlier: The results before, by folder.
        formats: The formats that were written.
    """
    names: list[str] = []
    dropped: list[str] = []
    for folder, result in earlier.items():
        own = [name for name in result.formats if name not in formats]
        gone = [name for name in result.files if not (folder / name).exists()]
        if own and gone:
            dropped += own
            names += gone
    if not names:
        return None
    listed = ", ".join(clean_text(name) for name in names[:MAX_LISTED_FILES])
    more = f" and {len(names) - MAX_LISTED_FILES} more" if len(names) > MAX_LISTED_FILES else ""
    wanted = ",".join(dict.fromkeys((*(name for name in formats if name != "joints_json"), *dropped)))
    return f"removed of the earlier prediction: {listed}{more} (add --format {wanted} to write them again)"
