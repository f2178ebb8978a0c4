"""Predict the joints of one object, and save them as joints.json.

Run it after `make demo`:  python examples/1_predict_an_object.py
With your own object:      python examples/1_predict_an_object.py cabinet.glb --workspace workspace
"""

import argparse
from pathlib import Path

import numpy as np

import kinmo

parser = argparse.ArgumentParser(description="Predict the joints of one object.")
parser.add_argument("shape", nargs="?", help="file or folder of the object; by default a shape of the demo")
parser.add_argument("--workspace", default="demo/workspace", help="workspace with trained networks")
parser.add_argument("--out", default="predicted", help="folder for joints.json")
options = parser.parse_args()

shape = kinmo.load(options.shape or min(Path("demo/partnet/partnet").iterdir()))
prediction = kinmo.Predictor(options.workspace).predict(shape)

print(f"{shape.id}: {len(shape.leaves)} parts with meshes, {len(prediction.joints)} joints")
for joint in prediction.joints:
    axis = np.round(joint.joint.direction, 3)
    print(f"  {joint.name} on {joint.parent}: {joint.kind.name.lower()} about {axis}, score {joint.score:.2f}")
print(prediction.save(options.out))
