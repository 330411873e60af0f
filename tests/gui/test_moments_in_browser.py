"""What the browser makes of messages at odd moments: while it runs, after a reload, a reset."""

import pytest

pytestmark = pytest.mark.slow


def disabled(host):
    buttons = host.tab.locator(".robsim-transport button >> visible=true").all()
    return {one.get_attribute("name") for one in buttons if one.is_disabled()}


def test_what_cannot_be_done_cannot_be_pressed(open_fake):
    host = open_fake()
    host.setup()
    host.state()
    assert disabled(host) == {"reset", "finish"}
    host.state(state="running")  # told before its first step
    assert disabled(host) == set()
    host.state(state="failed")  # in the first step
    assert disabled(host) == {"finish"}
    host.state(state="ended", k=9, steps=10)
    assert disabled(host) == {"start", "step", "step_stage"}
    host.state(state="closed", k=9, steps=10)
    assert disabled(host) == {"start", "step", "step_stage", "reset", "finish"}


def test_who_looks_back_while_nothing_runs_grants_room_too(open_fake):
    host = open_fake()
    host.setup()
    host.tab.evaluate("performance.now = () => 0; Date.now = () => 0")
    host.state(k=99, steps=100)
    host.tab.evaluate("performance.now = () => 6000")
    host.forget()
    for k in range(40, 34, -1):  # the room is for 8
        host.frame(k, past=True)
    assert host.sent("grant") == [{"type": "grant", "upto": 6 + 8, "late": False}]


@pytest.mark.parametrize(("sent", "room"), [(1000, 120), (-1000, 30)])
def test_room_is_for_less_on_a_line_that_fills(open_fake, sent, room):
    host = open_fake()
    host.setup()
    host.tab.evaluate("Date.now = () => 1000")
    host.tab.evaluate("performance.now = () => 0")
    host.frame(0, sent=1000)
    host.state(k=0, steps=1)
    host.tab.evaluate("performance.now = () => 200")  # 6 frames in 0.2 s: 30 a second
    host.forget()
    for k in range(1, 20):
        host.frame(k, sent=sent)
    assert host.sent("grant") == [{"type": "grant", "upto": 7 + room, "late": False}]


DRAWN = """
(at) => { // something other than the gray picture, in a column of it
  const canvas = document.querySelector(".robsim-camera canvas");
  const side = Math.min(canvas.width, canvas.height);
  const x = (canvas.width - side) / 2 + (at / 600) * side;
  const { data } = canvas.getContext("2d").getImageData(x - 4, canvas.height / 2, 8, 40);
  return data.some((value, i) => i % 4 < 3 && Math.abs(value - 190) > 20);
}
"""


def test_a_run_as_long_as_the_one_before_has_a_trail_of_its_own(open_fake):
    host = open_fake()
    host.setup(columns=[{"name": "pose_measured", "fields": ["x"] * 3, "units": [""] * 3}])
    before, after = ([[x, y, 0] for y in range(20, 580, 14)] for x in (150, 450))

    def drawn():
        host.rest(150)
        return [host.tab.evaluate(DRAWN, x) for x in (150, 450)]

    host.state(k=39, steps=40)
    host.frame(39, rows={"pose_measured": before})
    assert drawn() == [True, False]
    host.state(k=39, steps=40, resets=1)
    host.frame(39, rows={"pose_measured": after})
    assert drawn() == [False, True]


def test_a_reset_lets_the_charts_follow_and_ends_a_look_at_the_past(open_fake):
    host = open_fake()
    host.setup(columns=[{"name": "pose_true", "fields": ["x"] * 3, "units": [""] * 3}])
    host.state(k=299, steps=300)
    host.frame(299, rows={"pose_true": [[k, k, 0] for k in range(300)]})
    host.tab.keyboard.press("ArrowLeft")
    follow = host.tab.locator(".robsim-traces button[name=follow]")
    follow.click()
    assert follow.get_attribute("aria-pressed") == "false"
    host.forget()
    host.state(k=349, steps=350, resets=1)
    assert host.sent("look") == [{"type": "look", "k": None}]
    assert follow.get_attribute("aria-pressed") == "true"
