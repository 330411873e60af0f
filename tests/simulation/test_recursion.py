"""Simulations without end: each runs one in a callback of its own."""

import pytest

import robsim


@pytest.mark.long
def test_recursion_is_told_in_few_lines():
    def run():
        robsim.Simulation(control=lambda step: run()).run(1)

    with pytest.raises(RecursionError) as caught:
        run()
    assert caught.value.__notes__ == ["in the callback control at step 0"] * 8
    assert caught.value.callback.slot == "control"
