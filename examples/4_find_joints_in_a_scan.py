"""Find the parts and joints of an object in a depth scan.

Run it after `make demo`:  python examples/4_find_joints_in_a_scan.py
With your own scan:        python examples/4_find_joints_in_a_scan.py scan.npz --category refrigerator --workspace workspace

The scan is an .npz file with an array `points` [n, 3] in the camera's frame: x to the right, y down, z forward.
"""

import argparse

import numpy as np

import kinmo

parser = argparse.ArgumentParser(description="Find the parts and joints of an object in a scan.")
parser.add_argument("scan", nargs="?", default="demo/scan.npz", help=".npz file with the points")
parser.add_argument("--category", default="laptop", help="category of the object")
parser.add_argument("--workspace", default="demo/workspace", help="workspace with trained networks")
options = parser.parse_args()

points = np.load(options.scan)["points"].reshape(-1, 3)
points = points[points[:, 2] > 0.0]  # pixels without a depth have z = 0
predictor = kinmo.ScanPredictor.load(options.workspace, options.category)
prediction = predictor.predict(points)

for part in range(1 + len(predictor.structure.kinds)):
    print(f"part {part}: {np.count_nonzero(prediction.parts == part)} of {len(points)} points")
for place, (kind, state) in enumerate(zip(predictor.structure.kinds, prediction.estimate.states, strict=True), start=1):
    unit = "rad" if kind is kinmo.JointKind.REVOLUTE else "lengths of the scan"
    print(f"joint of part {place}: {kind.name.lower()}, at {state:.3f} {unit}")
