"""The still picture that remains in a saved notebook."""

import io

import numpy as np
import pytest
from PIL import Image

import robsim
from browsers import panel_of
from robsim.estimation.reference import ExtendedKalmanFilter
from small_runs import done
from threads import together

pytestmark = pytest.mark.long


def still_of(shown, **options):
    with robsim.panel(shown, **options) as panel:
        return panel.snapshot()


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


@pytest.fixture(scope="module")
def bare(simulation):
    return still_of(simulation)


def test_it_shows_camera_traces_and_histograms_in_few_bytes(bare):
    pixels = pixels_of(bare)
    assert len(bare) < 150_000
    camera, traces, histograms = (
        pixels[40:480, 10:450],
        pixels[40:480, 530:820],
        pixels[40:480, 870:],
    )
    assert is_there(camera, (200, 40, 40))  # the red square on the floor
    assert is_there(traces, (209, 0, 201))  # the truth
    assert is_there(histograms, (128, 200, 138))


def test_a_goal_is_drawn_with_its_heading(simulation, bare):
    pictures = bare, *(still_of(simulation, goals=at) for at in ((600, 600), (600, 600, 0.0)))
    none, at, posed = (pixels_of(one)[40:480, 10:450] for one in pictures)
    rings, arrows = (np.argwhere(abs(one - none).max(axis=2) > 60) for one in (at, posed))
    assert len(rings) > 50
    assert np.ptp(rings, axis=0).max() < 40
    assert np.ptp(arrows[:, 1]) > np.ptp(rings[:, 1]) + 10  # to the right
    assert np.ptp(arrows[:, 0]) < np.ptp(rings[:, 0]) + 5


def test_before_the_first_step_it_shows_the_start():
    pixels = pixels_of(still_of(robsim.Simulation(measure=True, seed=1)))
    assert is_there(pixels[40:480, 10:450], (200, 40, 40))
    assert not is_there(pixels[40:60, 10:70], (198, 40, 40))  # "not seen" would stand there
    assert (pixels[260:, 480:] > 250).all()


def test_there_is_one_of_a_trace_without_frames_and_of_an_experiment_without_a_robot(simulation):
    trace = robsim.Experiment([simulation.render_step(0)]).run()
    for shown in (trace, robsim.Experiment([None])):
        pixels_of(still_of(shown))


def test_a_callback_that_fails_at_the_start_leaves_the_picture_out_and_two_may_ask():
    def define_model():
        raise ValueError("wrong")

    found = []
    with robsim.panel(robsim.Simulation(define_model=define_model, seed=1)) as panel:
        together(*[lambda: found.append(panel.snapshot())] * 2)
    pixels_of(found[0])
    assert found[0] == found[1]


def test_steps_are_kept_for_those_alone_who_have_a_place_for_a_picture(monkeypatch):
    with panel_of(robsim.Simulation(measure=True, seed=1)) as (view, browser):
        done(view.driver.step())
        assert view.still._shot is None
        monkeypatch.setattr(browser, "keeps_still", True, raising=False)
        monkeypatch.setattr(browser, "keep", lambda picture: None)
        done(view.driver.step())
        assert view.still._shot.k == 1
