"""A Ray with two nodes."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest
from tests.dataset.jobs import example_jobs as jobs

from kinmo.core.errors import InputError, KinmoError
from kinmo.dataset.jobs import LocalRunner, RayRunner
from kinmo.dataset.jobs import cluster as module


def test_results_are_those_of_one_machine(cluster: Any) -> None:
    work = list(range(30))
    assert sorted(RayRunner(cluster.address).run(jobs.square, work)) == sorted(LocalRunner(2).run(jobs.square, work))


def test_all_nodes_work(cluster: Any, tmp_path: Path) -> None:
    assert len({node for _, node in RayRunner(cluster.address).run(jobs.meet, [tmp_path, tmp_path])}) == 2


def test_jobs_of_a_lost_node_run_again(cluster: Any, capfd: pytest.CaptureFixture[str]) -> None:
    lost = cluster.add_node(num_cpus=2)
    numbers = []

    def work():
        """Jobs until the node has done one, and some more."""
        while lost is not None or len(numbers) % 10:
            numbers.append(len(numbers))
            yield numbers[-1]

    results = []
    for number, node in RayRunner(cluster.address).run(jobs.nap_on_node, work()):
        results.append((number, node))
        if lost is not None and node == lost.node_id:
            cluster.remove_node(lost, allow_graceful=False)
            lost = None
    assert sorted(number for number, _ in results) == numbers
    assert all(isinstance(node, str) for _, node in results)
    assert capfd.readouterr().out == "", "commands print their result there, and nothing else"


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
