"""A cluster of Dask on loopback, for tests."""

import logging
import multiprocessing
from contextlib import contextmanager

import pytest


@contextmanager
def local_cluster(folder):
    """Give a client of a scheduler with two workers, which end with the context."""
    distributed = pytest.importorskip("distributed")
    dask = pytest.importorskip("dask")
    # A busy machine takes its time; and what is not there 15 s after it died is given up, even if
    # it is just being started once more.
    names = ("comm.timeouts.connect", "comm.timeouts.tcp", "deploy.lost-worker-timeout")
    patient = {f"distributed.{name}": "1 hour" for name in names}
    with dask.config.set(patient):
        cluster = distributed.LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",
            local_directory=str(folder),
            silence_logs=logging.CRITICAL,
        )
        with cluster, distributed.Client(cluster, timeout=300) as client:
            yield client
    assert not multiprocessing.active_children()
