"""How many parameters have the networks of each configuration?

    python bench/parameters.py [--quick]

Those of `paper` are held against the sizes of the release, layer by layer, in tests/learning/motion_gnn/test_network.py,
tests/learning/axis_selection/test_network.py and tests/learning/ancsh/test_network.py.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace

from torch import nn

from kinmo.config import builtin_configs, load_config
from kinmo.learning.motion_gnn.gnn_network import MotionGnn
from kinmo.methods.paper.axis_selection.siamese_network import AxisSelectionNetwork
from kinmo.scans.ancsh.ancsh_network import AncshNetwork, PartNetwork

PARTS = 3
RELEASED = 1_452_515
"""Of the public code's network, worked out layer by layer in the last of these tests."""


def count(network: nn.Module) -> int:
    """Numbers that are trained."""
    return sum(parameters.numel() for parameters in network.parameters())


def main() -> int:
    """Print one line a network."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="of `paper` alone")
    for name in ("paper",) if parser.parse_args().quick else builtin_configs():
        config = load_config(name)
        for types in (10, 5):
            print(f"{name:8} motion GNN, {types} types {count(MotionGnn(config.gnn, types)):>12,}")
        if config.gnn.inner_boxes:
            alone = replace(config.gnn, inner_boxes=False)
            print(f"{name:8} the same, 10 types, boxes of leaves alone {count(MotionGnn(alone, 10)):,}")
        print(f"{name:8} axis selection {count(AxisSelectionNetwork(config.axis)):,}")
        for kind, network in (("npcs", PartNetwork), ("ancsh", AncshNetwork)):
            print(f"{name:8} {kind}, objects of {PARTS} parts {count(network(config.ancsh, PARTS, PARTS)):,}")
    ours = count(AncshNetwork(load_config("paper").ancsh, PARTS, PARTS))
    line = {"claim": f"parameters of the network ancsh of `paper` for {PARTS} parts, as in the release", "ours": ours}
    print(json.dumps(line | {"peer": RELEASED, "ratio": RELEASED / ours, "goal": 1.0, "met": ours == RELEASED}))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
