"""Fixtures that tests of several modules use."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import settings

# A test process has one core: more threads would wait for each other. Processes that tests start inherit this.
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

pytest_plugins = ["workspace_fixtures"]

settings.register_profile("same", derandomize=True, deadline=None, max_examples=50)
settings.register_profile("fuzz", derandomize=False, print_blob=True, deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "same"))

REAL_DATA = Path(__file__).parents[1] / "data" / "partnet"


@pytest.fixture(scope="session")
def real_objects() -> list[Path]:
    """Folders of the real PartNet-Mobility objects, sorted; skips the test where there are none."""
    folders = sorted(file.parent for file in REAL_DATA.glob("*/*/mobility_v2.json"))
    if not folders:
        pytest.skip(f"no PartNet-Mobility objects below {REAL_DATA}")
    return folders
