"""Whether exported objects work in simulators: they load, stay at rest, move, and agree with kinmo's kinematics.

docs/background/metrics.md, "Simulators", defines the tests.

Usage:
    python bench/simulate.py RESULTS [--limit N] [--json FILE]
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from pathlib import Path

from common import option_parser, use_one_thread

use_one_thread()
import numpy as np

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body, Mobility
from kinmo.evaluation.simulation.expected_kinematics import expected_kinematics
from kinmo.evaluation.simulation.mujoco_simulator import MujocoSimulator
from kinmo.evaluation.simulation.object_check import SimulationCheck, check_object
from kinmo.evaluation.simulation.pybullet_simulator import PybulletSimulator
from kinmo.evaluation.simulation.simulator import LoadError

SIMULATORS = {"MuJoCo": MujocoSimulator, "PyBullet": PybulletSimulator}


def mobility_in(document: dict) -> Mobility:
    bodies = []
    for each in document["bodies"]:
        data = each["joint"]
        joint = data and Joint(
            JointKind(data["kind"]), np.array(data["direction"]), np.array(data["pivot"]), data["lower"], data["upper"], data["rest"]
        )
        bodies.append(Body(each["id"], each["name"], (), each["parent"], joint))
    return Mobility(tuple(bodies))


def main() -> int:
    parser = option_parser(__doc__, "two objects")
    parser.add_argument("results", type=Path)
    parser.add_argument("--limit", type=int)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    folders = sorted(path.parent for path in args.results.glob("*/joints.json"))[: args.limit]
    counts = {name: Counter() for name in SIMULATORS}
    every = []
    for folder in folders:
        document = json.loads((folder / "joints.json").read_text())
        shape = document["shape"]
        scale = document["export"]["metres_per_unit"]
        kinematics = expected_kinematics(mobility_in(document), np.array(shape["up"]), scale)
        for name, kind in SIMULATORS.items():
            try:
                simulator = kind(folder / f"{folder.name}.urdf")
            except LoadError as error:
                check = SimulationCheck(name, problems=(f"does not load: {error}",))
            else:
                check = check_object(name, simulator, kinematics, scale * shape["diagonal"])
            counts[name].update({"objects": 1, **{key: int(getattr(check, key)) for key in ("loads", "rests", "moves", "agrees", "works")}})
            every.append({"object": folder.name, "simulator": name, "works": check.works, "loads": check.loads, "rests": check.rests, "moves": check.moves, "agrees": check.agrees, "problems": check.problems})
            print(folder.name, name, check.works, *check.problems[:4], sep=" | ", flush=True)
    for name, found in counts.items():
        print(name, dict(found))
    if args.json:
        args.json.write_text(json.dumps(every, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
