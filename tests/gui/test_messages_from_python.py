"""Messages as a browser sends them, said by Python."""

import numpy as np
import pytest

import robsim


@pytest.fixture
def panel():
    with robsim.panel(robsim.Simulation(area=(300, 300), seed=1)) as panel:
        yield panel


def test_what_is_asked_is_answered(panel):
    assert panel.message("press", button="step") == []
    assert len(panel.trace) == 1
    (tree,) = panel.message("inspect", k=None, path=[])
    assert tree["type"] == "tree"
    assert "frame" in [node["name"] for node in tree["nodes"]]
    (source,) = panel.message("source", slot="control")
    assert "def control(step)" in source["text"]


@pytest.mark.long
def test_finish_has_drawn_its_figure(panel):
    panel.message("set", name="control", value="drive-around")
    for _ in range(6):
        panel.message("press", button="step")
    panel.message("press", button="finish")
    assert panel._view._result._newest[0]["type"] == "result"


def test_what_is_set_can_be_seen(panel):
    panel.message("set", name="tracking", value="default")
    panel.message("set", name="noise", value="gaussian")
    panel.message("press", button="step")
    assert panel.trace.is_tracked
    assert panel._what.noise.percent > 0


def test_a_refusal_is_an_error(panel):
    refused = [
        ("button 'jump'", ("press",), {"button": "jump"}),
        ("button", ("press",), {}),
        ("kind", ("jump",), {}),
        ("nois", ("set",), {"name": "nois", "value": "gaussian"}),
        ("noise_level", ("set",), {"name": "noise_level", "value": -5}),
    ]
    for named, arguments, fields in refused:
        with pytest.raises(ValueError, match=named):
            panel.message(*arguments, **fields)
    with pytest.raises(TypeError, match="fields"):
        panel.message("path", points=np.zeros((2, 2)))


def test_a_tool_takes_its_messages_too(user_folder):
    with robsim.gui.robot_panel(robot="lab") as tool:
        before = tool.value.alignment
        tool.message("turn", degrees=10)
        assert tool.value.alignment == pytest.approx(before + 10)
        with pytest.raises(ValueError, match="camera"):
            tool.message("resume")
    with pytest.raises(RuntimeError, match="closed"):
        tool.message("turn", degrees=10)
