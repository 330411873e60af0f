"""The panel in a real JupyterLab: shown, beside other cells, interrupted, run again, saved."""

import os
import re
import time

import pytest

pytest.importorskip("jupyterlab")
pytest.importorskip("anywidget")

from lab import Lab, lab_server, write_notebook

pytestmark = [pytest.mark.slow, pytest.mark.timeout(300)]

SHOW = """import robsim, threading, time
panel = robsim.panel(robsim.Simulation(measure=True, seed=1))
panel"""
THREADS = "print(sorted(t.name for t in threading.enumerate() if t.name.startswith('robsim ')))"
PANEL = ".robsim[data-state='{}']"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("lab")


@pytest.fixture(scope="module")
def server(folder):
    with lab_server(folder) as running:
        yield running


@pytest.fixture
def open_notebook(chromium, server, folder, request):
    contexts = []

    def open_it(*cells):
        name = f"{request.node.name}.ipynb"
        write_notebook(folder / name, cells)
        contexts.append(chromium.new_context(viewport={"width": 1500, "height": 1000}))
        return Lab(contexts[-1], server, name), folder / name

    yield open_it
    for context in contexts:
        context.close()


def shown(lab, state):
    lab.page.wait_for_selector(PANEL.format(state))


def picture(lab):
    """The picture that is on the screen now."""
    script = "document.querySelector('.robsim-camera canvas').toDataURL('image/jpeg', 0.5)"
    return lab.page.evaluate(script)


def count_pictures(lab, seconds):
    end = time.monotonic() + seconds
    seen = set()
    while time.monotonic() < end:
        seen.add(picture(lab))
        lab.page.wait_for_timeout(20)
    return len(seen)


def test_it_runs_beside_a_busy_cell_until_that_is_interrupted(open_notebook):
    lab, _ = open_notebook(SHOW, "time.sleep(60)", "print(panel)")
    lab.run(0)
    shown(lab, "paused")
    assert not lab.page.locator("[class^=robsim-still]").is_visible()
    lab.page.click("button[name=start]")
    shown(lab, "running")
    lab.run(1, until_done=False)
    assert count_pictures(lab, 3) > 3
    lab.page.click("button[name=pause]")
    shown(lab, "paused")
    lab.page.click("button[name=start]")
    shown(lab, "running")
    assert count_pictures(lab, 2) > 1
    assert lab.is_busy(1)
    lab.command("notebook:interrupt-kernel")
    shown(lab, "paused")
    assert "KeyboardInterrupt" in lab.output(1)
    lab.run(2)
    assert "Simulation, paused at step" in lab.output(2)


def test_a_cell_that_is_run_again_leaves_one_thread(open_notebook):
    lab, _ = open_notebook(SHOW, THREADS)
    for _ in range(2):
        lab.run(0)
        shown(lab, "paused")
        lab.page.click("button[name=start]")
        shown(lab, "running")
    lab.run(1)
    assert "['robsim driver', 'robsim panel']" in lab.output(1)


def still_in(notebook):
    """The picture that a notebook keeps below its first cell."""
    _, output = notebook.cells[0]["outputs"]
    return re.search(r"base64,([^\"]+)", output["data"]["text/html"])[1]


def test_a_saved_notebook_keeps_a_picture_and_comes_back(open_notebook, chromium):
    lab, file = open_notebook(SHOW, f"print(panel)\n{THREADS}")
    lab.run(0)
    shown(lab, "paused")
    first = still_in(lab.saved(file))
    for _ in range(3):
        lab.page.click("button[name=step]")
    lab.page.wait_for_timeout(3000)
    last = still_in(lab.saved(file))
    assert last != first
    assert shows_picture(chromium, file, last)
    lab.page.reload()
    lab.wait_until_idle()
    shown(lab, "paused")
    lab.page.click("button[name=step]")
    lab.run(1)
    assert "Simulation, paused at step 3" in lab.output(1)
    assert "['robsim driver', 'robsim panel']" in lab.output(1)


def shows_picture(chromium, file, picture):
    """Whether the notebook, converted for people without Python, shows it."""
    exporter = pytest.importorskip("nbconvert").HTMLExporter()
    page, _ = exporter.from_filename(file)
    assert picture in page
    html = file.with_suffix(".html")
    html.write_text(page)
    context = chromium.new_context(offline=True)
    tab = context.new_page()
    tab.goto(html.as_uri(), wait_until="commit")
    tab.wait_for_selector("[class^=robsim-still]")
    width = tab.locator("[class^=robsim-still]").evaluate("image => image.naturalWidth")
    context.close()
    return width == 1082


def test_a_kernel_that_is_restarted_ends_the_run(open_notebook):
    lab, _ = open_notebook(SHOW, THREADS + "; import os; print(os.getpid())")
    lab.run(0)
    shown(lab, "paused")
    lab.page.click("button[name=start]")
    shown(lab, "running")
    lab.run(1)
    (old,) = re.findall(r"\d+$", lab.output(1).strip())
    lab.command("notebook:restart-kernel")
    lab.page.click(".jp-Dialog .jp-mod-accept")
    lab.wait_until_idle()
    lab.run(0)
    shown(lab, "paused")
    lab.run(1)
    (new,) = re.findall(r"\d+$", lab.output(1).strip())
    assert new != old
    with pytest.raises(ProcessLookupError):
        os.kill(int(old), 0)
