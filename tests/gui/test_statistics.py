"""What is told of a record: histograms of its errors, its parameters."""

import math
import threading
from types import SimpleNamespace

import numpy as np
import pytest

import robsim
from browsers import panel_of
from robsim.gui.panels.analysis.statistics import Statistics


def statistics_of(trace):
    return Statistics(None).message(trace)


def trace_with(measured, true=None, **groups):
    n = len(measured)
    true = np.zeros((n, 3)) if true is None else true
    info = robsim.trace.RunInfo(dt=0.2, theta_true=np.ones((3, 5)))
    columns = {"pose_true": true, "u": np.zeros((n, 2)), "bounced": np.zeros(n)}
    return robsim.Trace({**columns, "pose_measured": measured, **groups}, info)


@pytest.mark.filterwarnings("error")
def test_an_estimate_that_runs_away_breaks_nothing():
    def estimate_state(step):
        return robsim.Estimate(np.full(3, -1.7e308 if step.k % 2 else 1.7e308), 1e308 * np.eye(3))

    with panel_of(robsim.Simulation(measure=True, estimate_state=estimate_state)) as (_, browser):
        browser.say("columns", names=["pose_estimated", "covariance"])
        for _ in range(4):
            browser.press("step")
        browser.take("state", k=3)
        errors = browser.take("statistics", last=3)[0]["errors"]
        assert [one["name"] for one in errors] == ["x", "y", "heading", "heading"]  # it is wrapped
        assert browser.all_of("note") == []


def test_errors_are_those_of_the_longest_record_without_a_gap():
    measured = np.zeros((12, 3))
    measured[:, 0] = [9, 9, 0, 1, 2, 3, 4, 2, 2, 2, 9, 9]
    measured[:, 2], true = np.deg2rad(-179), np.zeros((12, 3))
    true[:, 2] = np.deg2rad(179)
    measured[[1, 10]] = np.nan
    estimates = {"pose_estimated": np.full((12, 3), 0.5), "covariance": np.ones((12, 9))}
    found = statistics_of(trace_with(measured, true, **estimates))
    assert (found["first"], found["last"]) == (2, 9)
    x, _, heading, estimated = found["errors"][:4]
    assert (estimated["of"], estimated["name"], estimated["mean"]) == ("estimate", "x", 0.5)
    assert (x["of"], x["name"], x["unit"], x["n"]) == ("measurement", "x", "px", 8)
    assert (x["mean"], x["std"]) == (2.0, np.std([0, 1, 2, 3, 4, 2, 2, 2]))
    assert sum(x["counts"]) == 8
    assert x["low"] <= 0
    assert x["high"] >= 4
    assert (heading["unit"], heading["mean"]) == ("deg", pytest.approx(2))


def test_without_a_truth_or_a_measurement_there_are_none():
    unseen = statistics_of(trace_with(np.full((3, 3), np.nan)))
    nothing = {"first": None, "last": None, "errors": [], "nees": None}
    assert unseen == {"type": "statistics", **nothing}
    frames = [robsim.Simulation(seed=1).frame]
    assert statistics_of(robsim.Experiment(frames).run())["errors"] == []


@pytest.fixture
def computing(monkeypatch):
    """The time that it takes to compute them: none, unless a test lets it pass."""
    computing = SimpleNamespace(now=0.0)
    time = SimpleNamespace(monotonic=lambda: computing.now)
    monkeypatch.setattr("robsim.gui.panels.analysis.statistics.time", time)
    return computing


class FakePanel(SimpleNamespace):
    """What a `Statistics` uses of the panel; what is computed beside it is waited for."""

    is_over = False

    def __init__(self, **record):
        watched = [SimpleNamespace(is_watched=True)]
        super().__init__(record=SimpleNamespace(**record), is_running=True, links=watched)
        self.sent, self.jobs = [], []
        self.send, self.post = self.sent.append, self.jobs.append

    def guarded(self, compute):
        return compute()

    def look(self, statistics, now):
        due = statistics.look(now)
        if statistics._beside.is_busy:
            statistics.close(300)
            self.jobs.pop()()
        return due


def test_they_come_once_a_second_while_it_runs_and_at_once_on_pause(computing):
    trace = trace_with(np.zeros((9, 3)))
    panel = FakePanel(n_resets=0, n_steps=4, trace=trace)
    statistics = Statistics(panel)
    assert panel.look(statistics, 10.0) == 11.0
    panel.record.n_steps = 5
    assert panel.look(statistics, 10.5) == 11.0
    assert len(panel.sent) == 1
    assert panel.look(statistics, 11.0) == 12.0
    assert len(panel.sent) == 2
    assert panel.look(statistics, 12.0) == 13.0  # nothing is new
    assert len(panel.sent) == 2
    panel.record.n_steps = 6
    panel.is_running = False
    panel.look(statistics, 12.1)
    assert len(panel.sent) == 3
    assert panel.look(statistics, 12.2) == math.inf
    assert len(panel.sent) == 3


def test_those_of_a_run_before_a_reset_are_not_told():
    panel = FakePanel(n_resets=0, n_steps=4, trace=trace_with(np.zeros((4, 3))))
    statistics = Statistics(panel)
    statistics.look(10.0)
    statistics.close(300)
    panel.record.n_resets = 1
    panel.record.n_steps = 0
    statistics.changed()
    assert statistics.look(10.1) == math.inf  # one at a time
    panel.jobs.pop()()
    assert panel.sent == []


def test_those_that_take_long_come_less_often(computing):
    class Slow(Statistics):
        def message(self, trace):
            computing.now += 0.5
            return {}

    panel = FakePanel(n_resets=0, n_steps=10**6, trace=None)
    slow = Slow(panel)
    panel.look(slow, 10.0)
    panel.record.n_steps += 100
    assert panel.look(slow, 12.0) == 15.0
    assert computing.now == 0.5
    panel.is_running = False
    panel.look(slow, 12.1)
    assert computing.now == 1.0  # on pause at once


def test_closing_waits_for_what_is_computed(monkeypatch):
    inside, may_go_on, done = threading.Event(), threading.Event(), []

    def slow(self, trace):
        inside.set()
        may_go_on.wait(300)
        done.append(True)
        return {}

    wait = Statistics.close
    monkeypatch.setattr(Statistics, "message", slow)
    monkeypatch.setattr(Statistics, "close", lambda part, _: (may_go_on.set(), wait(part, 300)))
    with panel_of(robsim.Simulation(seed=1)) as (view, _):
        assert inside.wait(300)
        view.close()
        assert done


def parameters_of(simulation):
    with panel_of(simulation) as (_, browser):
        return browser.take("parameters")[0]


def run_of(steps=100, **options):
    simulation = robsim.Simulation(estimate_parameters=True, seed=1, **options)
    simulation.run(steps)
    return simulation


def test_a_robot_that_spins_excites_few_parameters():
    simulation = run_of()
    found = parameters_of(simulation)
    judged = robsim.identifiability(simulation.trace)
    assert found["values"] == simulation.trace.parameters[-1].ravel().tolist()
    assert found["errors"] == judged.standard_errors.ravel().tolist()
    assert found["excitation"]["good"] is False
    assert {"b1X", "b2X"} < {*found["excitation"]["weak"]}
    n = len(judged.names("not excited"))
    assert str(n) in found["excitation"]["text"]


def test_one_that_drives_around_excites_all():
    found = parameters_of(run_of(800, control=robsim.DriveAround()))
    assert (found["excitation"]["good"], found["excitation"]["weak"]) == (True, [])


def test_an_estimator_that_knows_no_errors_is_judged_by_its_samples():
    class Constant:
        theta = np.ones((3, 5))

        def update(self, phi, y):
            return self.theta

    found = parameters_of(run_of(init_parameter_estimator=lambda model: Constant()))
    assert found["values"] == [1.0] * 15
    assert found["excitation"]["good"] is False
    assert parameters_of(run_of(1))["excitation"]["good"] in (None, False)


def test_without_an_estimator_there_are_no_values():
    simulation = robsim.Simulation(seed=1)
    simulation.run(5)
    found = parameters_of(simulation)
    assert found["values"] is None
    assert found["excitation"] == {"text": "", "good": None, "weak": []}
    assert found["names"][:2] == ("a1X", "a2X")


def test_the_nees_tells_an_estimator_that_is_too_sure_from_one_that_is_right():
    rng = np.random.default_rng(7)
    true = np.tile([600.0, 600.0, 0.0], (300, 1))
    estimated = true + rng.normal(0, [2, 2, 0.05], (300, 3))
    for factor, verdict in ((1, "consistent"), (0.2, "optimistic"), (9, "conservative")):
        covariance = np.tile(np.diag([4, 4, 0.0025]).ravel() * factor, (300, 1))
        groups = {"pose_estimated": estimated, "covariance": covariance}
        told = statistics_of(trace_with(estimated, true, **groups))["nees"]
        assert (told["verdict"], told["n"]) == (verdict, 30)
        assert told["band"][0] < 3 < told["band"][1]
        unknown = statistics_of(trace_with(estimated, np.nan * true, **groups))["nees"]
        assert unknown == {"why": "unknown_truth"}
    assert statistics_of(trace_with(estimated, true))["nees"] is None
