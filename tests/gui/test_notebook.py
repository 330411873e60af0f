"""The host in notebooks, without JupyterLab: its line, its cells, what a saved notebook keeps."""

import gc
import sys
import threading
import weakref
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("anywidget")

import robsim
from robsim.gui.hosts import notebook as _notebook
from waiting import wait_for


def simulation():
    return robsim.Simulation(area=(300, 300), measure=True, seed=1)


@pytest.fixture
def panel():
    with robsim.panel(simulation(), speed=20) as opened:
        yield opened


@pytest.fixture
def link(panel):
    """A line whose widget keeps what is sent."""
    return kept(_notebook.NotebookLink(panel._view))


def kept(line):
    """Let a line's widget keep what is sent."""
    line.heads = []
    line.widget.send = lambda head, buffers: line.heads.append(head)
    return line


def say(link, *buffers, **message):
    """A message of the browser, as the kernel hands it over: in the main thread."""
    link._receive(link.widget, {"id": "me", **message}, [memoryview(one) for one in buffers])


def types(link):
    return [head["type"] for head in link.heads]


def test_the_line_carries_what_the_page_carries(panel, link):
    say(link, type="hello", width=150)
    wait_for(lambda: "frame" in types(link))
    assert types(link)[:2] == ["setup", "state"]
    say(link, type="grant", upto=50, late=False)
    say(link, type="press", button="step")
    wait_for(lambda: types(link).count("frame") == 2)


def test_the_line_carries_files(tmp_path):
    with robsim.gui.color_panel(np.zeros((9, 9, 3), np.uint8), file=tmp_path / "c.toml") as tool:
        link = kept(_notebook.NotebookLink(tool._view))
        say(link, b"nothing", type="upload", key="1", name="p.png", size=7, at=0)
        wait_for(lambda: any(head.get("state") == "refused" for head in link.heads))


def late(link):
    """Say hello, and then long enough that nothing has come."""
    say(link, type="hello", width=150)
    wait_for(lambda: link.sent == 1)
    for _ in range(3):
        before = link._n_late
        say(link, type="grant", upto=15, late=True)
        wait_for(lambda before=before: link._n_late != before or link._waiting is not None)
    wait_for(lambda: link._waiting)


def test_messages_that_are_not_delivered_are_fetched(panel, link):
    delivered = []

    def colab(head, buffers):
        if threading.current_thread() is threading.main_thread():
            delivered.append(head)

    link.widget.send = colab
    late(link)
    assert delivered == []

    def asked(*kinds):
        say(link, type="grant", upto=1000, late=False)
        return {*kinds} <= {head["type"] for head in delivered}

    wait_for(lambda: asked("polled"))
    assert delivered[0] == {"type": "polled", "gap": 100}
    say(link, type="press", button="start")
    wait_for(lambda: asked("state", "frame"))
    numbers = [head["n"] for head in delivered if head["type"] == "frame"]
    assert numbers == sorted(numbers)


def test_messages_are_fetched_no_longer_than_needed(panel, link):
    link._try_gap = 0.0
    late(link)
    panel._view.note("told later")
    wait_for(lambda: {"type": "polled", "gap": 0} in link.heads)
    assert "note" not in types(link)  # it was not asked for
    say(link, type="hello", width=150)  # as it has come
    wait_for(lambda: "note" in types(link))
    panel._view.note("told at once")
    wait_for(lambda: types(link).count("note") == 2)


@pytest.mark.long
def test_whoever_fetches_nothing_gets_no_more_until_he_is_back_and_rows_come_again(panel, link):
    panel.step()
    say(link, type="columns", names=["u"])
    late(link)
    wait_for(lambda: link.rows == {"u": 1})
    for i in range(300):
        panel._view.post(lambda i=i: panel._view.send({"type": "note", "text": str(i)}))
    wait_for(lambda: not link.is_watched)  # it is taken to be gone
    assert len(link._waiting) <= 200
    panel.step()
    wait_for(lambda: link.rows == {"u": 2})  # on their way to nobody

    def rows_after_setup():
        say(link, type="grant", upto=1000, late=False)
        since = types(link)[::-1].index("setup")
        return [entry["first"] for head in link.heads[-since:] for entry in head.get("rows", ())]

    link.heads[:] = [{"type": "setup"}]
    assert wait_for(rows_after_setup)[0] == 0


def test_a_slow_run_and_frames_that_come_late_are_no_line_that_does_not_deliver(link):
    link.greet("me")
    for _ in range(5):
        link.grant("me", 24, late=True)
    for number in range(1, 6):  # as at the slowest speed
        link.sent = number
        link.grant("me", 24 + number, late=True)
    link.sent = 9
    for _ in range(5):  # then nothing comes, as to one who looks at a past step
        link.grant("me", 24 + 9, late=True)
    assert link._waiting is None


def test_answers_may_come_on_any_shell(link):
    comm = SimpleNamespace(_reply_subshell_id="main")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(type(link.widget), "comm", comm)
        link.send({"type": "note"})
    assert vars(comm) == {}


def test_a_closed_widget_is_sent_nothing(panel, link):
    link.close()
    link.send({"type": "note"})
    wait_for(lambda: panel._view.links == [])


class Cells:
    """The cells of a notebook, which show panels."""

    def __init__(self):
        self._runs = 0

    def run(self, cell, *panels):
        self._runs += 1
        parent = {"metadata": {"cellId": cell}, "header": {"msg_id": str(self._runs)}}
        for panel in panels:
            _notebook._replace(parent, panel, _notebook.NotebookLink(panel._view))


@pytest.fixture
def cells(monkeypatch):
    monkeypatch.setattr(_notebook, "_cells", {})
    before = set(threading.enumerate())
    yield Cells()
    for shown in _notebook._cells.values():
        for _, panel, _ in shown:
            if panel() is not None:
                panel().close()
    wait_for(lambda: set(threading.enumerate()) <= before)


def test_a_cell_that_is_run_again_closes_what_it_showed_but_not_what_it_shows(cells):
    first, second = robsim.panel(simulation()), robsim.panel(simulation())
    cells.run("a", first)
    cells.run("b", robsim.panel(simulation()))
    cells.run("a", first)
    assert first.state == "paused"
    wait_for(lambda: len(first._view.links) == 1)
    cells.run("a", first, second)
    assert [first.state, second.state] == ["paused", "paused"]
    cells.run("a", second)
    assert (first.state, second.state) == ("closed", "paused")


def test_what_another_cell_shows_stays(cells):
    panel, other = robsim.panel(simulation()), robsim.panel(simulation())
    cells.run("a", panel)
    cells.run("b", panel)
    cells.run("a", other)
    assert panel.state == "paused"
    cells.run("b", other)
    assert panel.state == "closed"


@pytest.mark.long
def test_a_closed_panel_is_let_go_of_though_its_cell_shows_it(cells):
    panel = robsim.panel(simulation())
    cells.run("a", panel)
    panel.step()
    gone = weakref.ref(panel), weakref.ref(panel._view), weakref.ref(panel._view.runner)
    panel.close()
    del panel
    wait_for(lambda: gc.collect() is not None and not any(one() for one in gone))
    ((_, _, link),) = _notebook._cells["a"]
    say(link, type="hello", width=150)  # its widget is still there
    cells.run("a", robsim.panel(simulation()))


def test_a_front_end_without_names_for_cells(panel):
    _notebook._replace({"header": {"msg_id": "1"}}, panel, _notebook.NotebookLink(panel._view))
    assert panel.state == "paused"


def test_interrupting_a_cell_pauses(panel):
    for error, state in ((ValueError(), "running"), (KeyboardInterrupt(), "paused")):
        panel.start()
        _notebook._after_cell(SimpleNamespace(error_in_exec=error))
        panel._view.driver.call(lambda: None).result()
        assert panel.state == state


def test_where_it_cannot_be_shown_it_says_what_does(panel, monkeypatch, capsys):
    panel._ipython_display_()
    assert "open()" in capsys.readouterr().out
    monkeypatch.setitem(sys.modules, "robsim.gui.hosts.notebook", None)
    monkeypatch.delattr("robsim.gui.hosts.notebook")
    panel._ipython_display_()
    said = capsys.readouterr().out
    assert "robsim[notebook]" in said
    assert "open()" in said


SHOW = """import robsim
panel = robsim.panel(robsim.Simulation(measure=True))
display(panel)
panel.start()"""


@pytest.mark.slow
def test_a_kernel_with_an_open_panel_ends_without_a_word(tmp_path):
    jupyter = pytest.importorskip("jupyter_client")
    said = tmp_path / "said"
    manager = jupyter.KernelManager(kernel_name="python3")
    with said.open("wb") as file:
        manager.start_kernel(stdout=file, stderr=file)
        try:
            client = manager.client()
            client.start_channels()
            client.wait_for_ready(300)
            reply = client.execute_interactive(SHOW, timeout=300)
            assert reply["content"]["status"] == "ok"
            client.execute_interactive("while len(panel.trace) < 20: pass", timeout=300)
            client.shutdown()
            wait_for(lambda: manager.provisioner.process.poll() is not None)
            client.stop_channels()
        finally:
            manager.shutdown_kernel(now=True)
    assert "Traceback" not in said.read_text(errors="replace")
