"""The panel in a real JupyterLab: shown, beside other cells, interrupted, run again, saved."""

import contextlib
import json
import os
import re
import signal
from urllib.request import Request, urlopen

import numpy as np
import pytest

from bench_panel import hosts
from bench_panel.lab import Lab, lab_server, write_notebook
from painted_frames import assert_order
from robsim.vision import save_image
from waiting import wait_for

# Found, not loaded: that takes seconds, also where these tests are left out.
if not hosts.is_lab_there():
    pytest.skip("needs jupyterlab and anywidget", allow_module_level=True)

pytestmark = pytest.mark.slow

SHOW = """import robsim, threading, time
panel = robsim.panel(robsim.Simulation(measure=True, seed=1))
panel"""
TELL = """import os
names = [thread.name for thread in threading.enumerate()]
print(panel)
print(os.getpid())
print(names.count("robsim driver"), names.count("robsim view"))"""
CELLS = [SHOW, TELL, "time.sleep(3600)"]
PANEL = ".robsim[data-state='{}']"
STILL = "img[class^=robsim-still]"


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("bench_panel.lab._PATIENCE", 300.0)
        with lab_server(tmp_path_factory.mktemp("lab")) as running:
            yield running


@pytest.fixture
def file(server):
    file = server.folder / "panel.ipynb"
    write_notebook(file, CELLS)
    return file


@pytest.fixture
def lab(chromium, server, file):
    """The notebook, in which the panel has just been shown."""
    context = chromium.new_context(viewport={"width": 1500, "height": 1000})
    opened = Lab(context, server, file)
    opened.run(0)
    shown(opened, "paused")
    yield opened
    context.close()


def shown(lab, state):
    lab.page.wait_for_selector(PANEL.format(state))


def start(lab):
    lab.page.click("button[name=start]")
    shown(lab, "running")


def told(lab):
    """Return the words of Python on the panel, the number of threads of each kind, its process."""
    lab.run(1)
    *text, process, numbers = lab.output(1).strip().splitlines()
    return " ".join(text), [*map(int, numbers.split())], int(process)


def wait_for_pictures(lab, count):
    script = "document.querySelector('.robsim-camera canvas').toDataURL('image/jpeg', 0.5)"
    seen = set()
    wait_for(lambda: seen.add(lab.page.evaluate(script)) or len(seen) >= count)


def paused(lab, press):
    """Press as a user does, who presses again if nothing happens; return whether it paused."""
    if lab.page.locator(PANEL.format("running")).count():
        press()
    with contextlib.suppress(pytest.importorskip("playwright.sync_api").TimeoutError):
        return lab.page.wait_for_selector(PANEL.format("paused"), timeout=20_000)


def check_it_runs_beside_a_busy_cell_until_that_is_interrupted(lab):
    assert not lab.page.locator(STILL).is_visible()
    start(lab)
    lab.run(2, until_done=False)
    wait_for_pictures(lab, 4)
    wait_for(lambda: paused(lab, lambda: lab.page.click("button[name=pause]")))
    start(lab)
    wait_for_pictures(lab, 2)
    assert lab.is_busy(2)
    wait_for(lambda: paused(lab, lambda: lab.command("notebook:interrupt-kernel")))
    assert "KeyboardInterrupt" in lab.output(2)
    assert "Simulation, paused at step" in told(lab)[0]


def check_a_cell_that_is_run_again_ends_the_run_that_it_showed(lab):
    start(lab)
    lab.run(0)
    shown(lab, "paused")
    start(lab)
    assert told(lab)[1] == [1, 1]  # threads of each kind


def check_a_panel_says_that_its_kernel_is_gone(lab):
    is_inert = "button => button.closest('[inert]') !== null"
    agree = ".jp-Dialog button.jp-mod-accept"
    ends = [
        lambda: os.kill(told(lab)[2], signal.SIGKILL),
        lambda: lab.command("notebook:restart-kernel"),
    ]
    for end in ends:
        lab.run(0)
        shown(lab, "paused")
        start(lab)
        end()
        lab.page.click(agree)
        lab.page.wait_for_selector(".robsim[data-line=cut]")
        assert lab.page.locator("button[name=pause]").evaluate(is_inert)


def check_a_saved_notebook_keeps_the_picture_of_the_last_pause(lab, file, server):
    nbconvert = pytest.importorskip("nbconvert")
    first = still_in(lab.saved())
    last = still_after_steps(lab, 1)
    assert last != first
    assert last in nbconvert.HTMLExporter().from_filename(file)[0]

    lab.open()  # its kernel has gone on
    shown(lab, "paused")
    assert "Simulation, paused at step 0" in told(lab)[0]

    end_kernels(server)
    lab.open()
    picture = lab.page.locator(STILL)
    picture.wait_for()
    assert last in picture.get_attribute("src")
    assert picture.evaluate("image => image.complete && image.naturalWidth") == 1000


def still_in(notebook):
    """The picture that a notebook keeps below its first cell."""
    nbformat = pytest.importorskip("nbformat")
    _, output = nbformat.reads(notebook, 4).cells[0]["outputs"]
    return re.search(r"base64,([^\"]+)", output["data"]["text/html"])[1]


def still_after_steps(lab, n):
    """Do steps with the mouse; return the picture that the notebook keeps then."""
    before = lab.page.locator(STILL).get_attribute("src")
    for _ in range(n):
        lab.page.click("button[name=step]")
    lab.page.wait_for_selector(f"{STILL}:not([src='{before}'])", state="attached")
    return still_in(lab.saved())  # by its key: the panel has the focus, and leaves that to Lab


def end_kernels(server):
    for session in json.load(ask(server, "GET", "api/sessions")):
        ask(server, "DELETE", f"api/sessions/{session['id']}")


def ask(server, method, path):
    headers = {"Authorization": f"token {server.token}"}
    return urlopen(Request(f"{server.address}/{path}", headers=headers, method=method))


TOOL = """import robsim
tool = robsim.gui.color_panel()
tool"""
LOADED = ".robsim-tool-source:text-is('photo.png')"


def check_a_tool_takes_a_file_and_trains_a_colour(chromium, server):
    image = np.full((600, 800, 3), (120, 122, 118), np.uint8)
    image[200:400, 300:500] = 210, 40, 30
    image += np.random.default_rng(1).integers(0, 20, image.shape).astype(np.uint8)
    save_image(server.folder / "photo.png", image)
    assert (server.folder / "photo.png").stat().st_size > 1 << 19  # in more than one part
    write_notebook(server.folder / "tool.ipynb", [TOOL, "print(repr(tool.value))"])
    context = chromium.new_context(viewport={"width": 1500, "height": 1000})
    lab = Lab(context, server, server.folder / "tool.ipynb")
    lab.run(0)
    shown(lab, "paused")
    lab.page.set_input_files(".robsim input[name=picture]", server.folder / "photo.png")
    lab.page.wait_for_selector(LOADED)
    box = lab.page.locator(".robsim-camera canvas").bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    lab.page.mouse.move(*middle)
    lab.page.mouse.down()
    lab.page.mouse.move(*(at + 8 for at in middle), steps=4)
    lab.page.mouse.up()
    lab.page.wait_for_selector(".robsim-class[style*='rgb(255, 0, 0)']")
    lab.run(1)
    assert "ColorClass('red'" in lab.output(1)
    context.close()


def test_a_panel_and_a_tool_in_a_notebook(chromium, lab, file, server, monkeypatch):
    """All in one test: the server starts once, whoever runs it."""
    check_it_runs_beside_a_busy_cell_until_that_is_interrupted(lab)
    check_a_cell_that_is_run_again_ends_the_run_that_it_showed(lab)
    check_a_panel_says_that_its_kernel_is_gone(lab)
    lab.run(0)
    shown(lab, "paused")
    check_a_saved_notebook_keeps_the_picture_of_the_last_pause(lab, file, server)
    check_a_tool_takes_a_file_and_trains_a_colour(chromium, server)
    assert_order(monkeypatch, hosts, lambda s: hosts.measure_notebook(chromium, server, s))
