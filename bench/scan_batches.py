"""Batches of scans as networks of ANCSH are trained on: drawn from the files, as they are seen, and with what there is to say.

    python bench/scan_batches.py [--quick]

Scans of procedural refrigerators, 32 a batch of `small`, on one thread. Prints the least processor time of a batch over some
rounds of twenty. To compare two states of the code, run it in both, one after the other.
"""

from __future__ import annotations

import argparse
import json
import os
import tempfile
import time
from pathlib import Path

for variable in ("RAYON_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np

from kinmo.config import load_config
from kinmo.scans.ancsh.scan_batches import ScanData
from scan_to_joints import scanned

BATCHES = 20


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="a few rounds")
    rounds = 3 if parser.parse_args().quick else 15
    with tempfile.TemporaryDirectory() as folder:
        files = scanned(Path(folder), 8)
        data = ScanData(files, files[:1], load_config("small").ancsh)
        rng, times = np.random.default_rng(0), []
        for _ in range(rounds):
            batches = data.training_batches(0, rng)
            start = time.process_time()
            for _ in range(BATCHES):
                next(batches)
            times.append((time.process_time() - start) / BATCHES)
        claim, each = f"ms a batch of {data.config.batch_frames} scans", 1e3 * min(times)
        print(f"{claim}, of {len(files)} files: {each:.1f}")
        print(json.dumps({"claim": claim, "ours": each, "peer": None, "ratio": None, "goal": None, "met": None}))


if __name__ == "__main__":
    main()
