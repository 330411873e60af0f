"""The tools with fingers, in Chromium: corners, pinching."""

import numpy as np
import pytest

import robsim
from panel_mouse import ToolMouse
from waiting import wait_for

pytestmark = pytest.mark.slow


class Fingers(ToolMouse):
    """A tool in a tab, on a screen that is touched."""

    def __init__(self, tool, open_tool):
        super().__init__(tool, open_tool(tool, size=(820, 1180), has_touch=True))
        self.talk = self.tab.context.new_cdp_session(self.tab)
        self.canvas.scroll_into_view_if_needed()

    def touch(self, kind, *points):
        places = [
            dict(zip("xy", self.at(point), strict=True), id=i) for i, point in enumerate(points)
        ]
        self.talk.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": places})

    def drag(self, start, end):
        self.touch("touchStart", start)
        for share in np.linspace(0, 1, 6)[1:]:
            self.touch("touchMove", (1 - share) * np.array(start) + share * np.array(end))
        self.touch("touchEnd")

    def tap(self, point):
        self.tab.touchscreen.tap(*self.at(point))


def test_a_finger_drags_a_corner_and_taps_new_ones_and_two_zoom(open_tool, user_folder):
    with robsim.gui.robot_panel(robot="lab") as tool:
        fingers = Fingers(tool, open_tool)
        drawing = tool._view.drawing
        fingers.choose_part("red")
        fingers.tab.wait_for_selector("[value=red][aria-checked=true]")
        fingers.canvas.scroll_into_view_if_needed()
        before = drawing.sketch.markers["red"]
        # Fingers are thick: it begins a little beside the corner.
        fingers.drag(before[0] + (8, 6), before[0] + (30, -20))
        wait_for(lambda: np.abs(drawing.sketch.markers["red"] - before).max() > 15)
        fingers.tap(before.mean(axis=0))
        wait_for(lambda: len(drawing.sketch.markers["red"]) == len(before) + 1)
        sketch = drawing.sketch
        fingers.touch("touchStart", (200, 240), (280, 240))
        for spread in (60, 90, 130):
            fingers.touch("touchMove", (240 - spread, 240), (240 + spread, 240))
        fingers.touch("touchEnd")
        fingers.tab.wait_for_selector("[name=zoom_reset]:visible")
        fingers.choose_part("blue")  # told after all that the fingers did
        assert drawing.sketch is sketch
