from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any

import pytest

from kinmo.dataset.jobs import JobRunner, LocalRunner, RayRunner

NO_RAY = "needs Ray: pip install 'kinmo[cluster]'"


@pytest.fixture(scope="session")
def cluster() -> Iterator[Any]:
    """A Ray with two nodes on this machine."""
    pytest.importorskip("ray", reason=NO_RAY)
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    import ray
    from ray.cluster_utils import Cluster

    nodes = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    nodes.add_node(num_cpus=1)
    yield nodes
    ray.shutdown()
    nodes.shutdown()


@pytest.fixture(params=["local", "ray"])
def runner(request: pytest.FixtureRequest) -> JobRunner:
    if request.param == "local":
        return LocalRunner(workers=2)
    return RayRunner(request.getfixturevalue("cluster").address)
