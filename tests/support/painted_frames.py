"""What must be true of a measurement of the panel on any machine: order and freshness."""

from contextlib import suppress

import numpy as np

from bench_panel.figures import painted


def assert_order(monkeypatch, module, measure):
    """Assert that what is read back are frames of the run, one after the other."""
    found = {}

    def keep(host, watched, steps):
        found.update(watched=watched, steps=steps)
        return painted(host, watched, steps)

    monkeypatch.setattr(module, "painted", keep)
    numbers, seconds = [], 0.5
    while len(numbers) <= 3:  # a busy machine paints few
        assert seconds < 300
        with suppress(RuntimeError):  # it has painted none
            figures = measure(seconds)
        numbers = [k for k, _ in found["watched"].seen]
        seconds *= 4
    assert set(numbers) <= set(found["steps"])
    assert (np.diff(numbers) > 0).all()
    assert figures.latency_median > 0  # none is seen before it was there
    assert figures.busy > 0
