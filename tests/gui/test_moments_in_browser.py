"""What the browser makes of messages at odd moments: while it runs, after a reload, a reset."""

import pytest

pytestmark = pytest.mark.slow


def disabled(host):
    buttons = host.tab.locator(".robsim-transport button >> visible=true").all()
    return {one.get_attribute("name") for one in buttons if one.is_disabled()}


def test_reset_and_finish_can_be_pressed_while_the_first_run_goes_on(open_fake):
    host = open_fake()
    host.setup()
    host.state()
    assert disabled(host) == {"reset", "finish"}
    host.state(state="running")  # told before its first step
    assert disabled(host) == set()
    for button in ("reset", "finish"):
        host.tab.click(f".robsim-transport button[name={button}]")
    assert [message["button"] for message in host.sent("press")] == ["reset", "finish"]
    host.state(state="failed")  # in the first step
    assert disabled(host) == {"finish"}
    host.state(state="ended", k=9, steps=10)
    assert disabled(host) == {"start", "step", "step_stage"}
    host.state(state="closed", k=9, steps=10)
    assert disabled(host) == {"start", "step", "step_stage", "reset", "finish"}
