"""Score the trained networks on the test shapes of a workspace (paper, Table 1).

Run it after `make demo`:  python examples/5_evaluate.py
With your own workspace:   python examples/5_evaluate.py workspace --category refrigerator
"""

import argparse

import kinmo

parser = argparse.ArgumentParser(description="Score the trained networks on the test shapes.")
parser.add_argument("workspace", nargs="?", default="demo/workspace", help="workspace with trained networks")
parser.add_argument("--category", help="only shapes of this category")
options = parser.parse_args()

outcome = kinmo.evaluate(options.workspace, category=options.category)
for setting, tables in outcome.data.items():
    columns, rows = tables["summary"]["columns"], tables["summary"]["rows"]
    print(setting.replace("_", " "))
    for row in rows:
        figures = dict(zip(columns, row, strict=True))
        print(f"  {figures['method']}: {figures['ok']:.0%} of {figures['joints']} joints are right")
print(outcome.path)
