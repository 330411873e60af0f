"""What can be reached of a run while another thread runs it: snapshots, or a refusal in words."""

import copy
import pickle

import numpy as np
import pytest

import robsim
from sizes import thorough
from threads import running, together
from waiting import wait_for

pytestmark = pytest.mark.threads

LONG = 10**9  # steps, more than anybody waits for
OPTIONS = {
    "measure": True,
    "estimate_parameters": True,
    "area": (300, 300),
    "resolution": (75, 75),
    "seed": 1,
}


def simulation(**options):
    return robsim.Simulation(control=robsim.DriveAround(), **OPTIONS | options)


@pytest.fixture
def sim():
    """A simulation that has run, so that there is something to look at."""
    sim = simulation()
    sim.run(30)
    return sim


def outcome(look):
    """What a look from another thread comes to: "done", or how it was refused."""
    try:
        look()
    except RuntimeError as error:
        return str(error)
    return "done"


def outcomes(*looks):
    return {outcome(look) for _ in range(thorough(2000, 100)) for look in looks}


def public(thing):
    return [name for name in dir(thing) if not name.startswith("_")]


@pytest.mark.long
def test_the_estimator_belongs_to_the_run(sim):
    rls = sim.estimator
    uses = (
        lambda rls: rls.theta,
        lambda rls: rls.P,
        lambda rls: rls.standard_errors_unscaled,
        lambda rls: rls.n_samples,
        lambda rls: rls.reset(),
        lambda rls: rls.update(np.ones((3, 5)), np.ones(3)),
        repr,
        copy.copy,
        copy.deepcopy,
        pickle.dumps,
        lambda rls: rls == copy.copy(rls),
    )
    with running(sim, LONG):
        for use in uses:
            refused = outcomes(lambda use=use: use(rls), lambda use=use: use(sim.estimator))
            (words,) = refused
            assert "a run in another thread has this estimator" in words
    again = simulation()
    again.run(sim.n_steps)
    np.testing.assert_array_equal(again.trace.parameters, sim.trace.parameters)
    for use in uses:
        use(rls)  # afterwards it is anybody's again


@pytest.mark.long
def test_all_of_a_simulation_can_be_asked_for(sim):
    """Each property gives something, or says why not; none of them disturbs the run."""
    told = {}
    with running(sim, LONG):
        for name in public(type(sim)):
            if isinstance(getattr(type(sim), name), property):
                told[name] = outcomes(lambda name=name: getattr(sim, name))
        told["repr"] = outcomes(lambda: repr(sim))
    refused = {name: words for name, words in told.items() if words != {"done"}}
    assert set(refused) == {"last_step", "frame", "missed_detections"}
    for words in refused.values():
        assert all("another thread is running this simulation" in one for one in words)


def test_a_live_plot(sim):
    """A trace that is read during the run is the beginning of that at its end."""
    read = []
    with running(sim, LONG):
        while len(read) < 50 or len(read[-1]) < 100:
            read.append(sim.trace)
    whole = sim.trace
    for part in read:
        for name in ("pose_true", "pose_measured", "parameters", "u"):
            np.testing.assert_array_equal(getattr(part, name), getattr(whole, name)[: len(part)])


@pytest.mark.long
def test_nothing_can_be_changed(sim):
    with running(sim, LONG):
        for slot in sim.SLOTS:
            (words,) = outcomes(lambda slot=slot: setattr(sim, slot, None))
            assert "during a run" in words or "sim.reset()" in words
        for option in ("noise", "dropout", "process_noise"):
            (words,) = outcomes(lambda option=option: setattr(sim, option, None))
            assert "another thread is running" in words
        for change in (sim.reset, sim.step, sim.step_stage, lambda: sim.run(1)):
            (words,) = outcomes(change)
            assert "already running" in words
        (words,) = outcomes(lambda: sim.render_step(3))
        assert "another thread is running" in words


@pytest.mark.long
def test_a_run_ends_when_another_thread_says_so():
    sims = [simulation() for _ in range(2)]
    for _ in range(3):
        before = [sim.n_steps for sim in sims]

        def stop(before=before):
            for sim, n in zip(sims, before, strict=True):
                wait_for(lambda sim=sim, n=n: sim.n_steps > n)
            while any(sim.is_running for sim in sims):
                for sim in sims:
                    sim.stop()

        together(*(lambda sim=sim: sim.run(LONG) for sim in sims), stop)
        assert all(n < sim.n_steps < LONG for sim, n in zip(sims, before, strict=True))


def test_a_start_in_another_thread_is_seen_whole():
    """What is read while callbacks of the start run is that of before it, or of after."""
    sim = simulation()
    looks = []

    def slowly(result):
        n = len(looks)
        wait_for(lambda: len(looks) > n + 3)
        return result

    sim.define_model = lambda: slowly(robsim.RobotModel())
    sim.adjust_background = slowly

    def read():
        while sim.n_steps == 0:
            assert np.shape(sim.trace.info.theta_true) == (3, 5)
            looks.append(repr(sim))

    together(lambda: sim.run(3), read)
