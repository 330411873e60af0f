"""Other runs that drive along."""

import numpy as np
import pytest

import robsim
from browsers import panel_of


@pytest.fixture
def driven():
    """A panel after five steps, and its browser."""
    simulation = robsim.Simulation(seed=1, measure=True)
    simulation.run(5)
    with panel_of(simulation) as opened:
        yield opened


def ghosts_of(browser):
    """Return the ghosts that come next, {name: rows}."""
    head, buffers = browser.take("ghosts")
    rows = [np.frombuffer(one, "<f4").reshape(-1, 6) for one in buffers]
    return dict(zip(head["names"], rows, strict=True))


def test_a_run_that_is_kept_outlives_a_reset(driven):
    view, browser = driven
    trace = view.record.trace
    browser.say("keep")
    browser.press("reset")
    browser.take("state", steps=0)
    browser.say("hello", width=300)
    rows = ghosts_of(browser)["run 1"]
    np.testing.assert_allclose(rows[:, :3], trace.pose_true, rtol=1e-6)
    np.testing.assert_allclose(rows[:, 3:], trace.pose_measured - trace.pose_true, atol=1e-4)


def test_the_reference_drives_in_the_same_world(driven):
    view, browser = driven
    browser.say("reference")
    rows = ghosts_of(browser)["reference"]
    assert len(rows) >= 100
    np.testing.assert_allclose(rows[:5, :3], view.record.trace.pose_true, rtol=1e-6)


def test_a_saved_run_drives_along_until_it_is_removed(driven, tmp_path):
    view, browser = driven
    view.record.trace.save(tmp_path / "mine.npz")
    packed = (tmp_path / "mine.npz").read_bytes()
    browser.say("drop_ghost", name="none")
    assert ghosts_of(browser) == {}
    assert browser.upload(b"no trace", "bad.npz", key="2")["state"] == "refused"
    browser.say("upload", packed, key="3", name="mine.npz", size=len(packed), at=0)
    assert len(ghosts_of(browser)["mine"]) == 5
    browser.say("drop_ghost", name="mine")
    assert ghosts_of(browser) == {}
    for _ in range(3):
        browser.say("keep")
    assert browser.upload(packed, "mine.npz", key="4")["state"] == "refused"


def test_a_run_in_another_area_drives_along_nowhere(driven, tmp_path):
    _, browser = driven
    robsim.Simulation(area=(400, 300)).run(3).save(tmp_path / "small.npz")
    packed = (tmp_path / "small.npz").read_bytes()
    assert browser.upload(packed, "small.npz")["state"] == "refused"
    browser.say("keep")
    assert len(ghosts_of(browser)) == 1
    browser.say("set_option", name="area", value=[400, 300])
    browser.press("reset")
    assert ghosts_of(browser) == {}
    assert browser.upload(packed, "small.npz", key="2")["state"] == "taken"


def test_no_more_than_three_are_kept_and_none_of_no_steps(driven):
    _, browser = driven
    for _ in range(4):
        browser.say("keep")
    assert "remove one" in browser.take("note")[0]["text"]
    browser.press("reset")
    browser.take("state", steps=0)
    browser.say("drop_ghost", name="run 2")
    assert [*ghosts_of(browser)] == ["run 1", "run 3"]
    browser.say("keep")
    assert "nothing has run" in browser.take("note", level="error")[0]["text"]


def test_the_reference_drives_to_the_goal_where_the_users_controller_does_not():
    simulation = robsim.Simulation(seed=1, measure=True, control=lambda step: (0.0, 0.0))
    with panel_of(simulation, goals=np.array([700.0, 600.0])) as (_, browser):
        browser.say("reference")
        x, y = ghosts_of(browser)["reference"][-1, :2]
        assert np.hypot(x - 700, y - 600) < 30
