"""A Ray with two nodes."""

from __future__ import annotations

import sys
from typing import Any

import pytest

from kinmo.core.errors import InputError, KinmoError
from kinmo.dataset.jobs import LocalRunner, RayRunner, cluster as module
from tests.dataset.jobs import example_jobs as jobs


def test_results_are_those_of_one_machine(cluster: Any) -> None:
    work = list(range(30))
    assert sorted(RayRunner(cluster.address).run(jobs.square, work)) == sorted(LocalRunner(2).run(jobs.square, work))


def test_all_nodes_work(cluster: Any) -> None:
    assert len({node for _, node in RayRunner(cluster.address).run(jobs.node_of, range(12))}) == 2


def test_jobs_of_a_lost_node_run_again(cluster: Any) -> None:
    node = cluster.add_node(num_cpus=2)
    results = RayRunner(cluster.address).run(jobs.node_of, range(24))
    nodes = {number: where for number, where in (next(results) for _ in range(8))}
    cluster.remove_node(node, allow_graceful=False)
    nodes |= dict(results)
    assert sorted(nodes) == list(range(24))
    assert all(isinstance(where, str) for where in nodes.values())


def test_another_version_on_a_node_ends_the_run(cluster: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "__version__", "0.0.1")
    with pytest.raises(KinmoError, match=r"has kinmo .*, expected 0.0.1. Install 0.0.1 on all nodes"):
        list(RayRunner(cluster.address).run(jobs.square, range(3)))


def test_jobs_that_need_a_gpu_ask_for_one(cluster: Any) -> None:
    with pytest.raises(InputError, match="has no GPU"):
        list(RayRunner(cluster.address, gpus=0.5).run(jobs.square, range(3)))


def test_a_missing_ray_is_reported_with_a_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(InputError, match=r"pip install 'kinmo\[cluster\]'"):
        list(RayRunner("auto").run(jobs.square, range(3)))


@pytest.mark.parametrize("address", ["127.0.0.1:1", "no.such.host.invalid:6379", "nonsense"])
def test_an_address_without_a_cluster_is_reported_with_a_remedy(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    ray = pytest.importorskip("ray", reason="needs Ray: pip install 'kinmo[cluster]'")
    monkeypatch.setattr(ray, "is_initialized", lambda: False)
    with pytest.raises(InputError, match=r"ray start --head"):
        list(RayRunner(address).run(jobs.square, range(3)))
