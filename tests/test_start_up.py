"""Slow libraries that commands must not load without need."""

from __future__ import annotations

import subprocess
import sys


def loaded_by(script: str) -> set[str]:
    """Slow libraries that a fresh Python has loaded at the end of `script`."""
    watched = "print(*sorted({'torch', 'sklearn', 'pybullet'} & sys.modules.keys()))"
    process = subprocess.run(
        [sys.executable, "-c", f"import atexit, sys\natexit.register(lambda: {watched})\n{script}"],
        capture_output=True,
        text=True,
        check=True,
    )
    return set(process.stdout.splitlines()[-1].split())


def test_training_and_prediction_load_torch_and_no_other_slow_library() -> None:
    training = "import kinmo.pipeline.train_motion, kinmo.pipeline.scans.train_scans"
    prediction = (
        "import kinmo.pipeline.evaluation.evaluate_shapes, kinmo.pipeline.predict_shapes, kinmo.pipeline.pseudo_label_shapes"
    )
    assert loaded_by(training) == loaded_by(prediction) == {"torch"}


def test_the_report_needs_no_network() -> None:
    assert not loaded_by("import kinmo.view.html_report")
