"""Serial, threads, processes, any executor: the same bytes."""

import multiprocessing
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

import robsim
from campaign_code import Faster, Inline, failing_in_some, final, steady
from robsim.campaigns import campaign

SCENARIO = robsim.Scenario(
    area=(300, 300),
    start="random",
    control=robsim.DriveAround(),
    measure=True,
    noise=robsim.GaussianNoise(10),
    estimate_parameters=True,
)
VARY = {"motor_delay": [0, 1.5], "control": {"mine": Faster, "plain": steady}}


def run(**options):
    return campaign(
        SCENARIO,
        vary=VARY,
        metrics=["tracking", "parameters", final, failing_in_some],
        runs=6,
        steps=10,
        seed=3,
        progress=False,
        **options,
    )


@pytest.fixture(scope="module")
def serial():
    return run()


@pytest.mark.long
@pytest.mark.threads
def test_threads_give_the_same_bytes(serial):
    assert run(executor="threads").checksum == serial.checksum


def test_two_processes_give_the_same_bytes(serial):
    """The way of a campaign from end to end, in the tests that run at each change."""
    result = run(executor=2)
    assert result.checksum == serial.checksum
    assert result["error"].tolist() == serial["error"].tolist()
    assert result["line"].tolist() == serial["line"].tolist()


@pytest.mark.long
def test_any_executor_is_used_as_it_is_and_stays_open(serial):
    with ThreadPoolExecutor(3) as pool:
        assert run(executor=pool).checksum == serial.checksum
        assert pool.submit(int, "3").result() == 3
    assert run(executor=Inline()).checksum == serial.checksum


@pytest.mark.slow
def test_somebody_elses_processes_give_the_same_bytes(serial):
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        assert run(executor=pool).checksum == serial.checksum


@pytest.mark.long
def test_the_order_of_completion_does_not_matter(serial):
    class Backwards(Inline):
        """Gives the rows of each chunk in another order."""

        def submit(self, function, /, *args):
            future = super().submit(function, *args)
            future.result().reverse()
            return future

    result = run(executor=Backwards())
    assert result.checksum == serial.checksum
    np.testing.assert_array_equal(result["run"], serial["run"])


@pytest.mark.long
def test_code_that_cannot_be_sent_is_named_before_the_first_run():
    def inside():
        return steady

    with pytest.raises(TypeError, match="control 'mine'"):
        campaign(vary={"control": {"mine": inside}}, metrics=[final], runs=2, steps=2, executor=1)
    with pytest.raises(TypeError, match="metrics: 'x'"):
        campaign(metrics={"x": lambda trace: 0}, runs=2, steps=2, executor=1)


@pytest.mark.long
def test_an_executor_that_fails_says_how_to_go_on(tmp_path):
    class Broken(Inline):
        n = 0

        def submit(self, function, /, *args):
            self.n += 1
            if self.n > 3:
                raise RuntimeError("the cluster is gone")
            return super().submit(function, *args)

    with pytest.raises(RuntimeError, match="the cluster is gone") as caught:
        run(executor=Broken(), store=tmp_path / "store.sqlite")
    assert any("the same call continues" in note for note in caught.value.__notes__)
