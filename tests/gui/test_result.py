"""What Finish gives."""

import threading

import numpy as np
import pytest

import robsim
from browsers import panel_of

PNG = b"\x89PNG"


def finish(simulation):
    with panel_of(simulation) as (_, browser):
        browser.say("press", button="finish")
        return browser.take("result")


@pytest.mark.long
def test_a_run_gives_table_remarks_and_figure():
    simulation = robsim.Simulation(estimate_parameters=True, seed=1, control=robsim.DriveAround())
    trace = simulation.run(800)
    head, (figure,) = finish(simulation)
    report = robsim.batch_estimate(trace)
    name, true, batch, error, online = head["rows"][1]
    assert name == "a2X"
    assert (true, batch) == (trace.info.theta_true[0][1], report.batch[0, 1])
    assert (error, online) == (report.standard_errors[0, 1], trace.parameters[-1, 0, 1])
    assert "from truth" in head["text"]
    assert head["verdict"]
    assert head["good"] is True
    assert figure[:4] == PNG


@pytest.mark.long
def test_a_run_that_excites_too_little_says_which_parameters_are_lost():
    simulation = robsim.Simulation(seed=1)
    simulation.run(50)
    head, (figure,) = finish(simulation)
    assert "does not determine" in head["text"]
    assert "not excited" in head["verdict"]
    assert head["good"] is False
    assert None in np.ravel(head["rows"])  # not determined
    assert figure[:4] == PNG


def test_too_short_a_run_says_so():
    simulation = robsim.Simulation(seed=1)
    for steps, says in ((0, "nothing"), (4, "5 samples")):
        simulation.run(steps)
        head, figures = finish(simulation)
        assert says in head["text"]
        assert (head["rows"], head["verdict"], figures) == ([], "no estimate", [])


def test_finish_pauses_and_a_new_view_is_told_the_result_too():
    simulation = robsim.Simulation(seed=1)
    with panel_of(simulation) as (_, browser):
        browser.say("press", button="start")
        browser.take("state", state="running")
        browser.say("press", button="finish")
        browser.take("state", state="paused")
        head, _ = browser.take("result", again=False)
        browser.say("hello", width=300)
        assert browser.take("result")[0] == {**head, "again": True}
        browser.say("press", button="step")
        browser.take("state", k=simulation.n_steps)
        browser.say("hello", width=300)
        browser.take("frame")
        assert browser.all_of("result") == []


def test_the_panel_answers_while_it_is_estimated(monkeypatch):
    inside, may_go_on, calls = threading.Event(), threading.Event(), []

    def slow(trace):
        calls.append(len(trace))
        inside.set()
        may_go_on.wait(300)
        raise ValueError(str(len(trace)))

    monkeypatch.setattr("robsim.gui.panels.analysis.result.batch_estimate", slow)
    simulation = robsim.Simulation(seed=1)
    simulation.run(1)
    with panel_of(simulation) as (_, browser):
        for _ in range(20):
            browser.press("finish")
        assert inside.wait(300)
        browser.press("step")
        browser.take("state", k=1)
        browser.press("finish")
        may_go_on.set()
        assert [browser.take("result")[0]["text"] for _ in range(2)] == ["1", "2"]
    # One at a time; those asked for meanwhile are one. The last may have come a moment later.
    assert calls[:2] == [1, 2]
    assert len(calls) <= 3
