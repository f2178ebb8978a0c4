"""Move the predicted joints of an object, and export it as URDF.

Run it after `make demo`:  python examples/2_articulate_and_export.py
With your own object:      python examples/2_articulate_and_export.py cabinet.glb --workspace workspace
"""

import argparse
from pathlib import Path

import numpy as np

import kinmo

parser = argparse.ArgumentParser(description="Move the joints of an object, and export it.")
parser.add_argument("shape", nargs="?", help="file or folder of the object; by default a shape of the demo")
parser.add_argument("--workspace", default="demo/workspace", help="workspace with trained networks")
parser.add_argument("--out", default="exported", help="folder for the URDF; it is replaced")
options = parser.parse_args()

shape = kinmo.load(options.shape or min(Path("demo/partnet/partnet").iterdir()))
prediction = kinmo.Predictor(options.workspace).predict(shape)

opened = {}
for predicted in prediction.joints:  # as far as they move from the pose of the file
    joint = predicted.joint
    limits = [limit for limit in (joint.upper, joint.lower) if limit is not None]
    opened[predicted.name] = max(limits, key=lambda limit: abs(limit - joint.rest)) if limits else joint.rest + 0.5

for name, pose in prediction.articulate(opened).items():  # {link: [4, 4]}
    print(f"{name}: moved by {np.round(pose[:3, 3], 3)}")
size = np.ptp(prediction.articulated(opened).bounds, axis=0)
print(f"bounding box of the open object: {np.round(size, 3)}")

for path in prediction.export(options.out, formats=["urdf", "joints_json"], overwrite=True).values():
    print(path)
