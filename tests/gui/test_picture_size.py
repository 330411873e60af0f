"""The picture comes as large as it is shown, and the classes of colour as they are drawn."""

import io
import queue

import numpy as np
import pytest
from PIL import Image

import robsim
from browsers import panel_of
from robsim.gui._link import Link
from robsim.gui._panel.view import PanelView


class Recorder(Link):
    """A line that keeps the frames it is sent."""

    def __init__(self):
        super().__init__()
        self.pictures = queue.Queue()

    def transmit(self, head, buffers):
        if head["type"] == "frame":
            self.pictures.put(Image.open(io.BytesIO(buffers[0])))


@pytest.fixture
def view():
    view = PanelView(robsim.Simulation(seed=1))
    yield view
    view.close()


@pytest.mark.long
def test_a_paused_picture_comes_again_in_the_new_size(view):
    link = Recorder()
    view.connect(link)
    view.receive(link, {"type": "hello", "id": "a", "width": 600})
    assert link.pictures.get(timeout=10).size == (600, 600)
    view.receive(link, {"type": "size", "id": "a", "width": 1200})
    assert link.pictures.get(timeout=10).size == (1200, 1200)


def test_a_picture_is_reduced_by_a_whole_factor_and_its_message_has_the_cameras_size():
    frames = [robsim.Frame(np.zeros((1003, 1201, 3), np.uint8))]
    with panel_of(robsim.Experiment(frames, area=(1201, 1003), measure=False)) as (_, browser):
        browser.press("step")
        head, (picture,) = browser.take("frame")
    assert head["size"] == [1201, 1003]
    assert Image.open(io.BytesIO(picture)).size == (1201 // 4, 1003 // 4)  # not less than 300
