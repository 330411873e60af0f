"""`robsim.panel` and what it returns, its messages said by Python, without a browser."""

import base64
import io
import subprocess
import sys
import threading
import urllib.request

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

import robsim
from robsim.gui import Panel
from small_runs import robsim_threads
from threads import running
from waiting import wait_for


def simulation(**options):
    return robsim.Simulation(area=(300, 300), measure=True, seed=1, **options)


def quick_figure(record, shot, state, goals):
    """The real one takes half a second."""
    return Figure(figsize=(0.5, 0.1 * (1 + record.n_steps)))


@pytest.fixture
def panel():
    with robsim.panel(simulation()) as opened:
        yield opened
    wait_for(lambda: not robsim_threads())


def test_a_panel_of_the_same_run_is_the_same_until_it_is_closed():
    sim = simulation()
    with robsim.panel(sim, speed=20) as first:
        assert isinstance(first, Panel)
        assert robsim.panel(sim) is first
        assert first.speed == 20
        assert robsim.panel(sim, speed=7).speed == 7
        with robsim.panel(simulation()) as other:
            assert other is not first
    with robsim.panel(sim) as second:
        assert second is not first


def test_every_command_is_done_when_it_returns(panel):
    assert panel.state == "paused"
    assert [panel.step().k, panel.step().k] == [0, 1]
    panel.start()
    assert panel.state == "running"
    panel.speed = float("inf")
    wait_for(lambda: len(panel.trace) > 50)
    panel.pause()
    assert panel.state == "paused"
    done = len(panel.trace)
    assert panel.last_step.k == done - 1
    assert panel.last_step.frame.image.shape == (300, 300, 3)
    panel.reset()
    assert len(panel.trace) == 0
    stages = [panel.step_stage() for _ in range(3)]
    assert stages == ["measure", "control", "world"]
    assert panel.last_step.k == 0


def test_finish_pauses_and_estimates_once_for_table_and_caller(monkeypatch):
    made, told = [], []

    def estimate(trace):
        made.append(len(trace))
        return robsim.batch_estimate(trace)

    result = "robsim.gui.panels.analysis.result"
    monkeypatch.setattr(f"{result}.batch_estimate", estimate)
    monkeypatch.setattr(f"{result}._figure_of", lambda report: told.append(report) or b"")
    with robsim.panel(simulation(control=robsim.DriveAround()), speed=float("inf")) as panel:
        panel.start()
        wait_for(lambda: len(panel.trace) > 50)
        result = panel.finish()
        assert panel.state == "paused"
        n = len(panel.trace)
        wait_for(lambda: told)
        result.batch[:] = 0  # the panel's own stays as it is
        assert str(panel.finish()) == str(told[0]) == str(robsim.batch_estimate(panel.trace))
        panel.step()
        panel.finish()
        wait_for(lambda: told[-1].stop == n + 1)
    assert made == [n, n + 1]


def test_what_runs_elsewhere_gets_no_panel_until_it_ends():
    sim = simulation()
    with running(sim), pytest.raises(RuntimeError, match="running"):
        robsim.panel(sim)
    with robsim.panel(sim) as panel:
        panel.step()


def test_what_a_callback_raises_comes_out_of_the_step_and_stays_as_error():
    sim = simulation()

    @sim.control
    def control(step):
        return 1 / (2 - step.k), 0

    with robsim.panel(sim, speed=float("inf")) as panel:
        panel.step()
        panel.start()
        wait_for(lambda: panel.state == "failed")
        assert isinstance(panel.error, ZeroDivisionError)
        with pytest.raises(ZeroDivisionError):
            panel.step()
        with pytest.raises(ZeroDivisionError):
            panel.step_stage()
        assert len(panel.trace) == 2
        panel.reset()
        assert panel.error is None


def test_a_callback_may_pause_its_own_run():
    sim = simulation()

    @sim.control
    def control(step):
        if step.k == 3:
            robsim.panel(sim).pause()
        return 0.5, 0.4

    with robsim.panel(sim, speed=float("inf")) as panel:
        panel.start()
        wait_for(lambda: panel.state == "paused")
        assert len(panel.trace) == 4


def test_a_closed_panel_says_so_and_shows_its_end(monkeypatch):
    monkeypatch.setattr("robsim.gui.panels.still_picture._figure", quick_figure)
    sim = simulation()
    with robsim.panel(sim) as panel:
        panel.step()
    panel.close()
    panel.pause()  # as before, harmless
    assert panel.state == "closed"
    for command in (panel.start, panel.step, panel.step_stage, panel.reset, panel.open, panel.wait):
        with pytest.raises(RuntimeError, match="closed"):
            command()
    assert panel.last_step.k == 0
    assert panel.snapshot().startswith(b"\x89PNG")
    for word in ("Simulation", "closed", "step 0"):
        assert word in repr(panel)
    sim.run(3)  # the run is free again
    assert len(panel.trace) == 4


def test_a_snapshot_shows_the_panel_as_it_is(panel, tmp_path, monkeypatch):
    monkeypatch.setattr("robsim.gui.panels.still_picture._figure", quick_figure)
    before = panel.snapshot()
    panel.step()
    after = panel.snapshot()
    assert before != after
    panel.save(tmp_path / "panel.png")
    saved, snapshot = (
        np.asarray(Image.open(file).convert("RGB"))
        for file in (tmp_path / "panel.png", io.BytesIO(after))
    )
    np.testing.assert_array_equal(saved, snapshot)
    assert base64.b64decode(panel._repr_mimebundle_()["image/png"]) == after
    panel.start()
    assert panel.snapshot()
    assert panel.state == "running"


def test_its_page_is_served_when_it_is_opened(panel, monkeypatch):
    assert "robsim page" not in {thread.name for thread in threading.enumerate()}
    with urllib.request.urlopen(panel.url) as answer:
        assert b"page.js" in answer.read()
    opened = []
    start = "robsim.gui.hosts.page.Page.open"
    monkeypatch.setattr(start, lambda page: opened.append(page.url) or True)
    panel.open()
    assert opened == [panel.url]
    panel.open(port=int(panel.url.split(":")[2].split("/")[0]))
    with pytest.raises(ValueError, match="port"):
        panel.open(port=70000)
    monkeypatch.setattr(start, lambda page: False)
    with pytest.warns(UserWarning, match=panel.url):
        panel.open()


@pytest.mark.long
def test_what_is_loaded_when():
    code = (
        "import sys, robsim\n"
        "def loaded(): print({'tornado', 'anywidget', 'IPython', 'matplotlib'} & {*sys.modules})\n"
        "loaded(); robsim.panel; import robsim.gui; loaded()\n"
        "robsim.panel(robsim.Simulation()).step(); loaded()"
    )
    command = [sys.executable, "-W", "error", "-c", code]
    run = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert (run.stdout, run.stderr) == ("set()\n" * 3, "")


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
