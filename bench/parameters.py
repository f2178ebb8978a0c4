"""Number of parameters of the networks of each configuration.

The networks of `paper` have the sizes of the public code's networks. Tests work these out layer by layer: test_gnn_network.py,
test_siamese_network.py and test_ancsh_network.py.

Usage:
    python bench/parameters.py [--quick]
"""

from __future__ import annotations

from dataclasses import replace

from torch import nn

from common import option_parser, print_claims, print_table
from kinmo.config import builtin_configs, load_config
from kinmo.learning.motion_gnn.gnn_network import MotionGnn
from kinmo.methods.paper.axis_selection.siamese_network import AxisSelectionNetwork
from kinmo.scans.ancsh.ancsh_network import AncshNetwork, PartNetwork

PARTS = 3
"""Number of parts of an object for ANCSH."""
RELEASED = 1_452_515
"""Parameters of the public code's network ANCSH."""


def count(network: nn.Module) -> int:
    """Number of trained parameters."""
    return sum(parameters.numel() for parameters in network.parameters())


def main() -> int:
    """Print a line for each network."""
    quick = option_parser(__doc__, "the configuration `paper` alone").parse_args().quick
    rows = []
    for name in ("paper",) if quick else builtin_configs():
        config = load_config(name)
        rows += [(name, f"motion GNN, {types} types", count(MotionGnn(config.gnn, types))) for types in (10, 5)]
        if config.gnn.inner_boxes:
            leaves_only = replace(config.gnn, inner_boxes=False)
            rows.append((name, "motion GNN, 10 types, boxes of leaves only", count(MotionGnn(leaves_only, 10))))
        rows.append((name, "axis selection", count(AxisSelectionNetwork(config.axis))))
        for kind, network in (("npcs", PartNetwork), ("ancsh", AncshNetwork)):
            rows.append((name, f"{kind}, objects of {PARTS} parts", count(network(config.ancsh, PARTS, PARTS))))
    print_table(("configuration", "network", "parameters"), rows)
    ours = count(AncshNetwork(load_config("paper").ancsh, PARTS, PARTS))
    claim = f"parameters of ANCSH in `paper` for {PARTS} parts, as in the public code"
    print_claims(
        {"claim": claim, "ours": ours, "peer": RELEASED, "ratio": RELEASED / ours, "goal": 1.0, "met": ours == RELEASED}
    )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
