"""How many parameters have the networks of each configuration?

    python bench/parameters.py

Those of `paper` are held against the sizes of the release, layer by layer, in tests/learning/motion_gnn/test_network.py,
tests/learning/axis_selection/test_network.py and tests/learning/ancsh/test_networks.py.
"""

from __future__ import annotations

from dataclasses import replace

from torch import nn

from kinmo.config import builtin_configs, load_config
from kinmo.learning.ancsh.network import AncshNetwork, PartNetwork
from kinmo.learning.axis_selection.network import AxisSelectionNetwork
from kinmo.learning.motion_gnn.network import MotionGnn

PARTS = 3


def count(network: nn.Module) -> int:
    """Numbers that are trained."""
    return sum(parameters.numel() for parameters in network.parameters())


def main() -> int:
    """Print one line a network."""
    for name in builtin_configs():
        config = load_config(name)
        for types in (10, 5):
            print(f"{name:8} motion GNN, {types} types {count(MotionGnn(config.gnn, types)):>12,}")
        if config.gnn.inner_boxes:
            alone = replace(config.gnn, inner_boxes=False)
            print(f"{name:8} the same, 10 types, boxes of leaves alone {count(MotionGnn(alone, 10)):,}")
        print(f"{name:8} axis selection {count(AxisSelectionNetwork(config.axis)):,}")
        for kind, network in (("npcs", PartNetwork), ("ancsh", AncshNetwork)):
            print(f"{name:8} {kind}, objects of {PARTS} parts {count(network(config.ancsh, PARTS, PARTS)):,}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
