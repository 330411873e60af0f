"""What is told of a live camera: its rate, how old its newest frame is, how many were dropped."""

import pytest

import robsim
from browsers import panel_of
from python_devices import EndlessCamera, SteppedCamera
from small_runs import IMAGE, SOON, done, experiment
from waiting import wait_for

pytestmark = [pytest.mark.threads, pytest.mark.long]


@pytest.fixture(autouse=True)
def often(monkeypatch):
    monkeypatch.setattr("robsim.gui.panels.run.transport._GAP", 0.02)


def watched(camera):
    return panel_of(experiment(camera))


def told(browser, **state):
    return browser.take("state", **state)[0]["camera"]


def test_the_age_grows_while_a_camera_hangs_also_from_the_start_of_a_run():
    source = SteppedCamera([IMAGE] * 20)
    source.permits.release()
    with robsim.Camera(source, open_timeout=SOON) as camera:
        camera.read(SOON)
        with watched(camera) as (view, browser):
            assert told(browser)["age"] is None
            browser.press("start")
            for n_steps in range(2):
                wait_for(lambda n=n_steps: view.runner.n_steps == n)
                done(view.driver.call(lambda: None))  # its frame is known
                browser.say("hello", width=300)
                browser.take("setup")
                states = [told(browser, state="running", steps=n_steps) for _ in range(4)]
                ages = [state["age"] for state in states]
                assert ages == sorted(set(ages))
                source.permits.release()
            wait_for(lambda: told(browser, state="running")["age"] < ages[-1])


def test_while_it_is_paused_the_rate_is_told_and_nothing_counts_as_dropped():
    endless = EndlessCamera(IMAGE)
    with robsim.Camera(endless, open_timeout=SOON) as camera, watched(camera) as (view, browser):
        states = [told(browser, state="paused")]
        wait_for(lambda: camera.counts.dropped > 100)
        states += [told(browser, state="paused") for _ in range(6)]
        assert states[-1]["rate"] > 0
        assert {state["age"] for state in states} == {None}
        assert {state["dropped"] for state in states} == {0}
        view.driver.on_step.append(lambda step: wait_for(lambda: camera.counts.dropped > 10**3))
        browser.press("start")
        while not told(browser, state="running")["dropped"]:
            pass
        browser.press("pause")
        before = told(browser, state="paused")["dropped"]
        dropped = camera.counts.dropped
        wait_for(lambda: camera.counts.dropped > dropped + 100)
        assert {told(browser, state="paused")["dropped"] for _ in range(3)} == {before}
