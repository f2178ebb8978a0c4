"""Prepare a folder of annotated shapes, and train the networks for shapes.

Run it after `make demo`:  python examples/3_train_on_your_data.py
With your own shapes:      python examples/3_train_on_your_data.py partnet/ --workspace workspace
An interrupted run continues with the same command.
"""

import argparse

import kinmo

parser = argparse.ArgumentParser(description="Prepare shapes, and train on them.")
parser.add_argument("folder", nargs="?", default="demo/partnet", help="folder with shapes anywhere below it")
parser.add_argument("--workspace", default="demo/workspace", help="workspace for everything that kinmo makes")
parser.add_argument("--config", default="small", help="small (a CPU), paper (a GPU), or a TOML file")
options = parser.parse_args()

prepared = kinmo.prepare(options.folder, options.workspace)
for outcome in ("included", "repaired", "skipped"):
    print(f"{outcome}: {len(prepared.data[outcome])} shapes")
for shape in prepared.data["skipped"]:
    print(f"  {shape['path']}: {shape['reasons'][0]}")

trained = kinmo.train("motion", options.workspace, config=options.config)
for name, result in trained.data.items():
    print(f"{name}: {result['epochs']} epochs, validation error {result['error']:.3f}")
print(trained.path)
