"""The page's server, without a browser: lines, slow readers, its end."""

import socket
import threading
from contextlib import ExitStack
from types import SimpleNamespace

import pytest

import robsim
from browsers import Page, PanelView
from page_client import Client, connected, greeted, request
from small_runs import robsim_threads
from waiting import wait_for


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
    monkeypatch.setattr("webbrowser.open", lambda url: started.append(url) or True)
    return started


def test_the_address_that_starts_a_browser_leads_there_once(page, started, monkeypatch):
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
    assert request(page, path)[0] == 404
    assert request(page, "/")[0] == 404
    page.open()
    assert started[1] != url
