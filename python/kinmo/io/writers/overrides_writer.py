"""overrides.toml, written for a prediction that was corrected in Python (docs/guide/correct.md)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import tomli_w


def overrides_text(overrides: Mapping[str, Any]) -> str:
    """The text of overrides.toml with the content `overrides` (see `kinmo.core.overrides.Overrides.table`)."""
    return tomli_w.dumps(overrides)
