"""The page: its server, its module, its tabs in a browser."""

import json
import os
import re
import shutil
import socket
import subprocess
import sys
import threading
from contextlib import ExitStack, contextmanager
from types import SimpleNamespace

import pytest

import robsim
from browsers import Page, PanelView
from page_client import Client, connected, greeted, request
from robsim.gui.hosts.script import STATIC, page_script, script
from small_runs import robsim_threads
from waiting import wait_for

# --- the server


@pytest.fixture
def page():
    view = PanelView(robsim.Simulation(area=(300, 300), seed=1), speed=float("inf"))
    served = Page(view)
    yield served
    served.close()
    view.close(300)
    wait_for(lambda: not robsim_threads())


def test_the_files_come_with_headers_that_keep_others_out(page):
    for name, kind in {"": "html", "view.js": "javascript", "view.css": "css"}.items():
        status, headers, body = request(page, f"/{page.secret}/{name}")
        assert status == 200
        assert kind in headers["Content-Type"]
        assert body
        assert headers["Cache-Control"] == "no-store"
        assert headers["Referrer-Policy"] == "no-referrer"
        assert "default-src 'none'" in headers["Content-Security-Policy"]
        assert "Server" not in headers
        assert "Content-Encoding" not in headers


@pytest.mark.long
def test_two_pages_are_told_the_same_and_get_frames(page):
    with greeted(page) as client, greeted(page) as other:
        head, (picture,) = client.hear("frame")
        assert (head["n"], picture[:2]) == (1, b"\xff\xd8")
        client.say(type="press", button="start")
        ks = [client.hear("frame")[0]["k"] for _ in range(3)]
        assert ks == sorted(set(ks))
        while other.hear("frame")[0]["k"] < ks[-1]:
            pass


def test_a_page_that_does_not_read_is_cut_off_and_nothing_waits(page, monkeypatch):
    monkeypatch.setattr("robsim.gui.hosts.serving._MOST_BEHIND", 1 << 22)
    with greeted(page) as reader, greeted(page, line=connected(page, SO_RCVBUF=4096)):
        reader.say(type="press", button="start")
        for _ in range(20):
            page.view.post(lambda: page.view.send({"type": "note"}, bytes(1 << 20)))
            _, (block,) = reader.hear("note")
            assert len(block) == 1 << 20
        wait_for(lambda: len(page.pages) == 1)
        assert reader.hear("frame")
        assert page.view.driver.state == "running"


@pytest.mark.long
def test_a_page_that_is_cut_off_pauses_nothing_that_others_look_at(page, patience):
    patience(0.1)
    with greeted(page) as reader:
        greeted(page).line.close()
        wait_for(lambda: len(page.pages) == 1)
        reader.say(type="press", button="start")
        wait_for(lambda: page.view.driver.state == "running")
    wait_for(lambda: page.view.driver.state == "paused")


@pytest.mark.long
def test_waiting_ends_some_time_after_the_last_page(page, monkeypatch):
    now, looks = [100.0], []
    clock = SimpleNamespace(monotonic=lambda: looks.append(1) or now[0])
    monkeypatch.setattr("robsim.gui.hosts.page.time", clock)
    waiter = threading.Thread(target=page.wait, args=(3.0,))

    def waits_on():
        looked = len(looks)
        wait_for(lambda: len(looks) > looked + 1 or not waiter.is_alive())
        return waiter.is_alive()

    waiter.start()
    greeted(page).line.close()
    wait_for(lambda: page._left is not None)
    now[0] += 2
    with greeted(page):  # loaded anew
        now[0] += 2
        assert waiter.is_alive()
    wait_for(lambda: page._left is not None)
    now[0] += 2
    assert waits_on()
    now[0] += 2
    waiter.join(300)
    assert not waiter.is_alive()


@pytest.mark.long
def test_a_page_that_python_has_cut_off_has_a_minute_to_return(page, monkeypatch):
    now = [100.0]
    clock = SimpleNamespace(monotonic=lambda: now[0])
    monkeypatch.setattr("robsim.gui.hosts.page.time", clock)
    with greeted(page):
        (socket,) = page.pages
        page._loop.call_soon_threadsafe(socket.cut)
        wait_for(lambda: not page.pages)
    assert page._left == 160.0
    greeted(page).line.close()
    wait_for(lambda: page._left is not None)
    assert page._left == 100.0


@pytest.mark.long
def test_the_server_ends_while_messages_are_under_way(page):
    with ExitStack() as stack:
        clients = [stack.enter_context(greeted(page)) for _ in range(3)]
        asleep = connected(page, SO_RCVBUF=4096)
        sleeper = stack.enter_context(Client(page, line=asleep))
        for client in (*clients, sleeper):
            client.say(type="hello", width=300)
        clients[0].say(type="press", button="start")
        assert clients[0].hear("frame")
        stack.enter_context(connected(page)).sendall(b"GET /half")
        page.close()
        wait_for(lambda: not page._thread.is_alive())
        assert all(client.is_closed() for client in clients)
    page.view.send({"type": "note"})  # to nobody


def test_it_listens_on_loopback_alone_on_a_port_that_is_free(page):
    address = page._listening.getsockname()[0]
    assert address == "127.0.0.1"
    assert page._listening.family == socket.AF_INET
    with pytest.raises(OSError, match=str(page.port)):
        Page(page.view, port=page.port)
    for port in (-1, 65536):
        with pytest.raises(ValueError, match="port"):
            Page(page.view, port=port)


@pytest.fixture
def started(monkeypatch):
    """The addresses that a browser was started with."""
    started = []
    monkeypatch.setattr("sys.platform", "linux")
    for name in ("WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr("robsim.gui.hosts.page._COMING", 1e6)  # s; nothing here is in a hurry
    monkeypatch.setattr("webbrowser.open", lambda url: started.append(url) or True)
    return started


def test_the_address_that_starts_a_browser_leads_there_once(page, started, monkeypatch, capsys):
    monkeypatch.setenv("DISPLAY", "")
    assert page.open() is False
    assert started == []
    monkeypatch.setenv("DISPLAY", ":0")
    assert page.open() is True
    (url,) = started
    assert page.secret not in url  # others may read it
    path = url.removeprefix(f"http://127.0.0.1:{page.port}")
    status, headers, body = request(page, path)
    assert (status, headers["Location"], body) == (302, f"/{page.secret}/", b"")
    with greeted(page):  # the page has come
        assert request(page, "/")[0] == 404
        page.open()
        assert started[1] != url
        assert request(page, path)[0] == 404  # of a ticket that is gone
    assert capsys.readouterr().err == ""


def test_a_page_ends_that_somebody_else_may_have(started, capsys, monkeypatch):
    with robsim.panel(robsim.Simulation(area=(300, 300), seed=1)) as panel:
        panel.open()
        page = panel._page
        path = started[0].removeprefix(f"http://127.0.0.1:{page.port}")
        assert request(page, path)[0] == 302
        assert request(page, path)[0] == 403
        panel.wait()
        assert "used twice" in capsys.readouterr().err

        monkeypatch.setattr("robsim.gui.hosts.page._COMING", 0.01)
        panel.open()
        assert page.secret not in panel.url  # another one
        assert request(panel._page, "/" + panel._page.ticket.word)[0] == 302
        panel.wait()
        assert "no page connected" in capsys.readouterr().err


class Terminal:
    """A terminal that stops at the first word, or is gone; `words` holds its input."""

    def __init__(self, *, is_gone):
        self.goes_on, self.is_gone, self.words = threading.Event(), is_gone, []

    def write(self, word):
        self.words.append(word)
        if self.is_gone:
            raise BrokenPipeError
        self.goes_on.wait(300)

    def flush(self):
        pass


@pytest.mark.parametrize("is_gone", [False, True])
def test_a_terminal_that_takes_no_words_stops_no_page(page, started, monkeypatch, is_gone):
    terminal = Terminal(is_gone=is_gone)
    monkeypatch.setattr("sys.stderr", terminal)
    page.open()
    path = "/" + page.ticket.word
    try:
        monkeypatch.setattr("robsim.gui.hosts.page.stranger", lambda *ends: "another user (5)")
        assert [request(page, path)[0] for _ in range(3)] == [403] * 3
        assert request(page, f"/{page.secret}/")[0] == 200
        wait_for(lambda: terminal.words)
        assert len([word for word in terminal.words if "(5)" in word]) == 1
        monkeypatch.setattr("robsim.gui.hosts.page.stranger", lambda *ends: "")
        assert [request(page, path)[0] for _ in range(2)] == [302, 403]
        wait_for(lambda: not page._thread.is_alive())
    finally:
        terminal.goes_on.set()


OPENING = """
import pathlib, time, webbrowser
import robsim
panel = robsim.panel(robsim.Simulation(area=(300, 300), seed=1))
panel.open()
while not pathlib.Path("seen").exists():
    time.sleep(0.01)
"""
BROWSER = """
import os, pathlib, sys, time, urllib.request
parent = os.getppid()
while not pathlib.Path("spied").exists() and os.getppid() == parent:
    time.sleep(0.01)
with urllib.request.urlopen(sys.argv[1]) as page:
    pathlib.Path("seen.part").write_bytes(page.read())
pathlib.Path("seen.part").rename("seen")
"""
SPY = r"""
import encodings.idna, os, pathlib, re, urllib.error, urllib.request
address = re.escape(os.getcwd().encode()) + rb"/browser[.]py\0(http://127.0.0.1:[^\0]+)"
os.setuid(65534)
found = None
while not found:
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            called = (process / "cmdline").read_bytes()
        except OSError:
            continue
        found = found or re.search(address, called)
try:
    urllib.request.urlopen(found[1].decode())
except urllib.error.HTTPError as error:
    print(error.code, error.read().decode())
"""


@pytest.mark.skipif(
    sys.platform != "linux" or os.geteuid() != 0, reason="needs a second user: root alone has one"
)
def test_another_user_who_reads_the_address_of_a_browser_does_not_get_the_page(tmp_path):
    browser = tmp_path / "browser.py"
    browser.write_text(BROWSER)
    environment = {**os.environ, "BROWSER": f"{sys.executable} {browser} %s &"}
    with (
        run_aside([sys.executable, "-c", SPY], tmp_path) as spy,
        run_aside([sys.executable, "-c", OPENING], tmp_path, env=environment) as program,
    ):
        refused, fault = spy.communicate(timeout=300)
        assert refused.startswith("403 "), fault
        (tmp_path / "spied").touch()
        _, said = program.communicate(timeout=300)
    refusal = r"robsim: another user \(65534\) .* go to http://127\.0\.0\.1:\d+/\S+/\n"
    assert re.fullmatch(refusal, said)
    assert b"<title>robsim" in (tmp_path / "seen").read_bytes()


@contextmanager
def run_aside(command, folder, env=None):
    """Run a program beside the test, and end it at the latest with that."""
    with subprocess.Popen(
        command, cwd=folder, env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            yield process
        finally:
            process.kill()


# --- the module and its texts


def test_each_file_has_a_scope_of_its_own():
    files = [file for file in STATIC.rglob("*.js") if file.name != "page.js"]
    top = re.findall(r"^const (\w+) = \(\(\) => {$", script(), re.MULTILINE)
    assert len(set(top)) == len(top) == len(files)
    # Whatever else begins a line is inside one of them.
    outside = re.sub(r"^const \w+ = \(\(\) => {$.*?^}\)\(\);$", "", script(), flags=re.M | re.S)
    names = re.findall(r"^(?:async )?(?:const|let|class|function) (\w+)", outside, re.MULTILINE)
    assert names == ["TEXTS"]


def test_the_module_imports_nothing():
    assert re.findall(r"^(?:import|export (?!default))", script(), re.MULTILINE) == []


def test_no_text_becomes_code_or_elements():
    ways = r"(?:inner|outer)HTML|insertAdjacentHTML|document\.write|srcdoc|\beval\(|new Function"
    handlers = r"setAttribute\(['\"`]on|javascript:"
    code = script() + page_script()
    assert re.findall(f"{ways}|createContextualFragment|parseFromString|{handlers}", code) == []


@pytest.mark.long
def test_node_can_read_it(tmp_path):
    node = shutil.which("node")
    if node is None:
        pytest.skip("needs node")
    (tmp_path / "view.mjs").write_text(script(), "utf-8")
    assert subprocess.run([node, "--check", tmp_path / "view.mjs"], check=False).returncode == 0


TEXTS = json.loads((STATIC / "texts.json").read_text("utf-8"))
CODE = {str(file.relative_to(STATIC)): file.read_text("utf-8") for file in STATIC.rglob("*.js")}
#: Functions whose first text is the name of one.
ASKING = r"text|makeButton|makeWords|makeHint|makeAct\(context"


def test_every_text_that_is_asked_for_is_there():
    asked = {
        (file, name)
        for file, code in CODE.items()
        for name in re.findall(rf'\b(?:{ASKING})[(,]\s*"([^"]+)"(?!, \{{\}}, )', code)
    }
    assert len(asked) > 50
    assert {(file, name) for file, name in asked if name not in TEXTS} == set()


def test_names_that_are_made_up_begin_as_texts_do():
    made = {
        (file, start)
        for file, code in CODE.items()
        for start in re.findall(r"\btext\(\s*`([\w.]+\.)\$\{", code)
    }
    assert {one for one in made if not any(name.startswith(one[1]) for name in TEXTS)} == set()


# --- a real browser


MAIN = "main[data-state='{}']"


@pytest.fixture
def served(chromium):
    """A page of our own, so that it can be closed; what the browser complains of is not asked."""
    view = PanelView(robsim.Simulation(area=(300, 300), measure=True, seed=1))
    page = Page(view)
    context = chromium.new_context()
    context.set_default_timeout(300_000)  # ms
    yield view, page, context
    context.close()
    page.close()
    view.close(300)


def shown(context, page, state="paused"):
    tab = context.new_page()
    tab.goto(page.url)
    tab.wait_for_selector(MAIN.format(state))
    return tab


@pytest.mark.slow
def test_a_broken_line_is_mended_and_one_that_stays_broken_pauses_the_run(served, patience):
    patience(1000.0)  # s: the run goes on till it is back
    view, page, context = served
    tab = shown(context, page)
    tab.click("button[name=start]")
    tab.wait_for_selector(MAIN.format("running"))
    (socket,) = page.pages
    page._loop.call_soon_threadsafe(socket.cut)
    wait_for(lambda: page.pages and socket not in page.pages)
    tab.wait_for_selector(MAIN.format("running"))
    assert view.driver.state == "running"
    patience(0.0)
    (socket,) = page.pages
    page._loop.call_soon_threadsafe(socket.cut)
    tab.wait_for_selector(MAIN.format("paused"))
    assert view.driver.state == "paused"
    wait_for(lambda: len(view.links) == 1)


@pytest.mark.slow
def test_a_page_tells_that_python_has_gone(served):
    _, page, context = served
    tab = context.new_page()
    tab.clock.install()  # its pauses take no time
    tab.goto(page.url)
    tab.wait_for_selector(MAIN.format("paused"))
    page.close()
    tab.wait_for_selector(MAIN.format("lost"))
    while tab.locator(MAIN.format("lost")).count():  # each try takes a while
        tab.clock.run_for(10_000)
        tab.wait_for_timeout(50)
    tab.wait_for_selector(MAIN.format("gone"))


@pytest.mark.slow
def test_what_a_callback_says_is_text(open_panel):
    code = '</script><img src=x onerror="document.title=1"><script>document.title=1</script>'

    def control(step):
        raise ValueError(code + "\u202e\x1b[31m" + "x" * 10**6)

    control.__name__ = code
    _, tab = open_panel(robsim.Simulation(seed=1, control=control))
    tab.locator("button[name='step']").first.click()
    tab.wait_for_selector("main[data-state='failed']")
    error = tab.locator(".robsim-error-text")
    error.wait_for()
    assert code in error.text_content()
    tab.locator("button[name='to_callbacks']").click()
    row = tab.locator(".robsim-slot", has_text=code[:20]).first
    row.wait_for()
    assert tab.title() != "1"
    assert tab.locator("main img, main script").count() == 0


@pytest.mark.slow
def test_prints_are_shown_from_their_end(open_panel):
    def control(step):
        print("step", step.k)
        return 0.1, 0.2

    view, tab = open_panel(robsim.Simulation(area=(300, 300), seed=1, control=control))
    for _ in range(60):
        view.driver.step().result()
    tab.get_by_role("tab", name="Callbacks").click()
    prints = tab.locator(".robsim-printed")
    prints.get_by_text("step 59").wait_for()
    at_end = "list => list.scrollHeight > list.clientHeight && "
    at_end += "list.scrollTop + list.clientHeight > list.scrollHeight - 4"
    wait_for(lambda: prints.evaluate(at_end))
