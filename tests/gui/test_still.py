"""The still picture that remains in a saved notebook."""

import io
import threading

import numpy as np
import pytest
from PIL import Image

import robsim
from browsers import panel_of
from robsim.gui._panel.view import PanelView
from robsim.reference import ExtendedKalmanFilter

pytestmark = pytest.mark.long


def still_of(shown, **options):
    view = PanelView(shown, **options)
    try:
        return view.snapshot()
    finally:
        view.close()


def pixels_of(png):
    picture = Image.open(io.BytesIO(png))
    assert picture.format == "PNG"
    assert picture.size == (1000, 500)
    return np.asarray(picture.convert("RGB")).astype(int)


def is_there(pixels, color):
    """Whether there are some pixels near a colour."""
    return np.count_nonzero(np.abs(pixels - color).max(axis=2) < 40) > 50


@pytest.fixture(scope="module")
def simulation():
    simulation = robsim.Simulation(
        measure=True,
        estimate_state=ExtendedKalmanFilter(),
        noise=robsim.UniformNoise(40),
        dropout=robsim.Dropout(0.2),
        seed=1,
    )
    simulation.run(60)
    return simulation


def test_it_shows_camera_traces_and_histograms_in_few_bytes(simulation):
    pixels = pixels_of(png := still_of(simulation))
    assert len(png) < 150_000
    camera, traces, histograms = (
        pixels[40:480, 10:450],
        pixels[40:480, 530:820],
        pixels[40:480, 870:],
    )
    assert is_there(camera, (200, 40, 40))  # the red square on the floor
    assert is_there(traces, (209, 0, 201))  # the truth
    assert is_there(histograms, (128, 200, 138))


def test_a_goal_is_drawn_with_its_heading(simulation):
    bare, at, posed = (
        pixels_of(still_of(simulation, goals=goals))[40:480, 10:450]
        for goals in (None, np.array([600.0, 600.0]), np.array([600.0, 600.0, 0.0]))
    )
    rings, arrows = (np.argwhere(abs(one - bare).max(axis=2) > 60) for one in (at, posed))
    assert len(rings) > 50
    assert np.ptp(rings, axis=0).max() < 40
    assert np.ptp(arrows[:, 1]) > np.ptp(rings[:, 1]) + 10  # to the right
    assert np.ptp(arrows[:, 0]) < np.ptp(rings[:, 0]) + 5


@pytest.mark.slow
def test_noise_does_not_make_it_large():
    simulation = robsim.Simulation(noise=robsim.GaussianNoise(100), seed=1)
    simulation.run(2)
    png = still_of(simulation)
    pixels_of(png)
    assert len(png) < 150_000


def test_before_the_first_step_it_shows_the_start():
    pixels = pixels_of(still_of(robsim.Simulation(measure=True, seed=1)))
    assert is_there(pixels[40:480, 10:450], (200, 40, 40))
    assert not is_there(pixels[40:60, 10:70], (198, 40, 40))  # "not seen" would stand there
    assert (pixels[260:, 480:] > 250).all()


def test_there_is_one_of_a_trace_without_frames_and_of_an_experiment_without_a_robot(simulation):
    trace = robsim.Experiment([simulation.render_step(0)]).run()
    for shown in (trace, robsim.Experiment([None])):
        pixels_of(still_of(shown))


def test_a_callback_that_fails_at_the_start_leaves_the_picture_out():
    def define_model():
        raise ValueError("wrong")

    pixels_of(still_of(robsim.Simulation(define_model=define_model, seed=1)))


def test_two_threads_may_ask_at_a_time():
    view = PanelView(robsim.Simulation(seed=1))
    found = []
    threads = [threading.Thread(target=lambda: found.append(view.snapshot())) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    view.close()
    assert len(found) == 2
    assert found[0] == found[1]


def test_steps_are_kept_for_those_alone_who_have_a_place_for_a_picture(monkeypatch):
    with panel_of(robsim.Simulation(measure=True, seed=1)) as (view, browser):
        view.driver.step().result(20)
        assert view.still._shot is None
        monkeypatch.setattr(browser, "keeps_still", True, raising=False)
        monkeypatch.setattr(browser, "keep", lambda picture: None)
        view.driver.step().result(20)
        assert view.still._shot.k == 1
