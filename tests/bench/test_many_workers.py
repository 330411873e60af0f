"""Campaigns with many workers, simulated: what is known in closed form comes out."""

import pytest

from robsim.bench._campaign.dask_tasks import TaskCost
from robsim.bench._campaign.many_workers import simulated
from robsim.bench._campaign.parent import ParentCost
from robsim.bench._campaign.scaling import Scaling

FREE = ParentCost(submit=0.0, receive=0.0, row=0.0, flying=0.0)


@pytest.mark.parametrize("spread", [0, 0.5])
def test_a_parent_without_costs_keeps_all_workers_busy(spread):
    for workers in (1, 7, 100):
        found = simulated(FREE, 0.0, workers=workers, chunk=5, seconds=0.1, spread=spread)
        assert found.rate == pytest.approx(workers / 0.1, rel=0.03 if spread else 0.005)
        assert found.workers == pytest.approx(1)
        assert (found.parent, found.scheduler) == (0, 0)


def test_one_worker_waits_for_nobody_while_the_parent_is_quicker():
    parent = FREE._replace(submit=0.02, receive=0.03, row=0.01)
    found = simulated(parent, 0.04, workers=1, chunk=4, seconds=0.1, spread=0)
    # 0.4 s of the worker; 0.02 + 0.03 + 4 * 0.01 s of the parent beside it
    assert found.rate == pytest.approx(10, rel=0.01)
    assert found.parent == pytest.approx(0.09 / 0.4, rel=0.01)
    assert found.scheduler == pytest.approx(0.04 / 0.4, rel=0.01)


@pytest.mark.parametrize("chunk", [1, 10])
def test_a_parent_that_is_always_busy_is_the_limit(chunk):
    parent = FREE._replace(submit=1e-3, receive=2e-3, row=1e-4)
    found = simulated(parent, 1e-4, workers=200, chunk=chunk, seconds=0.01)
    assert found.rate == pytest.approx(chunk / (3e-3 + chunk * 1e-4), rel=0.02)
    assert found.parent == pytest.approx(1)
    assert found.workers == pytest.approx(found.rate * 0.01 / 200, rel=0.1)


def test_a_scheduler_that_is_always_busy_is_the_limit():
    found = simulated(FREE, 2e-3, workers=100, chunk=3, seconds=0.01)
    assert found.rate == pytest.approx(3 / 2e-3, rel=0.01)
    assert found.scheduler == pytest.approx(1)


def test_chunks_in_flight_cost_at_each_awakening():
    parent = FREE._replace(flying=1e-3)
    found = simulated(parent, 0.0, workers=1, chunk=1, seconds=0.1, spread=0)
    assert found.parent == pytest.approx(2 * 1e-3 / 0.1, rel=0.01)


def test_the_chunk_that_is_needed_leaves_the_calling_process_free():
    parent = ParentCost(submit=1e-5, receive=5e-5, row=5e-6, flying=4e-7)
    task = TaskCost(client=1e-3, scheduler=1e-3)
    needed = Scaling(parent=parent, task=task, by_workers={}, by_duration={}).chunk_needed(1.0)
    whole = parent._replace(submit=parent.submit + task.client)
    found = simulated(whole, task.scheduler, workers=1000, chunk=needed, seconds=1.0)
    # (1.06 ms + 2000 * 0.4 us) / (0.1 ms - 5 us)
    assert needed == 20
    assert 0.08 < found.parent < 0.1
    assert found.workers > 0.99


def test_no_chunk_is_large_enough_where_rows_are_too_much():
    parent = FREE._replace(receive=1e-6, row=1e-5)
    scaling = Scaling(parent=parent, task=TaskCost(0, 0), by_workers={}, by_duration={})
    assert scaling.chunk_needed(0.1) is None
    assert scaling.chunk_needed(0.2) == 1
