"""The picture comes as large as it is shown, and the classes of colour as they are drawn."""

import io

import numpy as np
import pytest
from PIL import Image

import robsim
from browsers import panel_of


def size_of_next(browser):
    head, (picture,) = browser.take("frame")
    return head["size"], Image.open(io.BytesIO(picture)).size


@pytest.mark.long
def test_a_paused_picture_comes_again_in_the_new_size():
    with panel_of(robsim.Simulation(seed=1), width=600) as (_, browser):
        assert size_of_next(browser)[1] == (600, 600)
        browser.say("size", width=1200)
        assert size_of_next(browser)[1] == (1200, 1200)


def test_a_picture_is_reduced_by_a_whole_factor_and_its_message_has_the_cameras_size():
    frames = [robsim.Frame(np.zeros((1003, 1201, 3), np.uint8))]
    with panel_of(robsim.Experiment(frames, area=(1201, 1003), measure=False)) as (_, browser):
        browser.press("step")
        # not less than 300, which the browser asks for
        assert size_of_next(browser) == ([1201, 1003], (1201 // 4, 1003 // 4))
