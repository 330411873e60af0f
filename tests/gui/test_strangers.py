"""Whom the page's server refuses, and what it lets pass: others on this machine, other sites."""

import json
import logging
import random
import socket
import threading
from contextlib import ExitStack, suppress

import pytest

import robsim
from browsers import FakeBrowser, Page, PanelView, panel_of
from page_client import BINARY, Client, connected, greeted, request
from sizes import thorough
from waiting import wait_for


@pytest.fixture
def page(caplog):
    """A page; nothing that strangers do is worth a line of a log."""
    view = PanelView(robsim.Simulation(area=(300, 300), seed=1))
    served = Page(view)
    yield served
    served.close()
    view.close()
    assert [one for one in caplog.records if one.levelno >= logging.WARNING] == []


def paths(page):
    mine = page.secret
    other = mine[:-1] + ("A" if mine[-1] != "A" else "B")
    return [
        *("/", "//", f"/{other}/", f"/{other}/socket", f"/{other}/nothing", f"/{mine[:-1]}/"),
        *(f"/{mine}", f"/{mine}/nothing", f"/{mine}//socket", "/favicon.ico", "/%ff/", "/\xe4/x"),
        *(f"/{mine}/../view.js", f"/{mine}/static/texts.json", f"/{mine.swapcase()}/"),
    ]


def told(answer):
    """What an answer gives away: all but the time."""
    status, headers, body = answer
    return status, {k: v for k, v in headers.items() if k != "Date"}, body


def test_a_wrong_secret_and_a_wrong_path_look_the_same(page):
    answers = [told(request(page, path)) for path in paths(page)]
    assert answers[0][0] == 404
    assert answers[0][2] == b""
    assert all(answer == answers[0] for answer in answers)


def test_a_name_that_was_bent_to_this_machine(page):
    for host in ("evil.example", "evil.example:{port}", "127.0.0.1", "localhost:1"):
        for name in ("", "socket"):
            path = f"/{page.secret}/{name}"
            assert request(page, path, Host=host.format(port=page.port))[0] == 403


def test_another_site(page):
    local = "127.0.0.1:{port}"
    for origin in ("http://evil.example", f"https://{local}", "null", local, "", "file://"):
        origin = origin.format(port=page.port)
        for name in ("", "view.js"):
            assert request(page, f"/{page.secret}/{name}", Origin=origin)[0] == 403
        with Client(page, Origin=origin) as client:
            assert client.status == 403


def test_our_own_pages_may_come(page):
    for host in ("127.0.0.1", "localhost"):
        place = f"{host}:{page.port}"
        with Client(page, Host=place, Origin=f"http://{place}") as client:
            assert client.status == 101
        assert request(page, f"/{page.secret}/", Host=place)[0] == 200


def test_there_is_nothing_but_get(page):
    for method in ("POST", "PUT", "DELETE", "OPTIONS", "HEAD", "PATCH", "BREW"):
        status, _, body = request(page, f"/{page.secret}/", method=method)
        assert (status, body) == (405, b"")
        assert request(page, "/wrong/", method=method)[0] in (404, 405)
    length = {"Content-Length": str(1 << 40)}  # is not waited for
    assert request(page, f"/{page.secret}/", method="POST", **length)[0] == 400


MALFORMED = [
    *(b"", b"{", b"[]", b"null", b"1e999", b'"text"', b"{}", b'{"type":"hello"}', b"[" * 100_000),
    *(b'{"type":["hello"]}', b'{"type":{}}', b"9" * 5000, b'{"id":"me","type":"go"}'),
    *(b'{"id":"me","type":"grant","upto":NaN,"late":true}', b'{"id":1,"type":"bye"}'),
    *(b'{"id":"me","type":"hello","width":-1}', b'{"id":"me","type":"hello","width":true}'),
    json.dumps({"id": "me", "type": "set", "name": "speed", "value": "x" * 201}).encode(),
    json.dumps({"id": "me", "type": "path", "points": [[1, 2]] * 1001}).encode(),
    json.dumps({"id": "me" * 200, "type": "bye"}).encode(),
]


def test_a_malformed_message_is_told_and_forgotten(page):
    for message in MALFORMED:
        with greeted(page) as client:
            client.send(message)
            assert client.hear("note")[0]["level"] == "error"
    with greeted(page) as client:
        client.send(b'{"id":"me","type":"press","button":"start"}', BINARY)  # none is binary
        assert client.hear("note")[0]["level"] == "error"
        assert page.view.driver.state == "paused"
        client.say(type="press", button="step")
        assert client.hear("frame")


def test_text_that_is_no_text_ends_the_line(page):
    with greeted(page) as client, greeted(page) as other:
        client.send(b"\xff\xfe")
        assert client.is_closed()
        other.say(type="press", button="step")
        assert other.hear("frame")


def test_the_largest_message(page):
    with greeted(page) as client:
        client.send(b" " * (1 << 20))
        assert client.hear("note")
        with suppress(ConnectionError):  # closed, and the rest not read
            client.send(b" " * ((1 << 20) + 1))
        assert client.is_closed()
        wait_for(lambda: not page.pages)


@pytest.mark.long
def test_commands_do_not_pile_up_while_a_callback_hangs():
    inside, is_free = threading.Event(), threading.Event()

    def control(step):
        inside.set()
        is_free.wait(300)
        return 0, 0

    with panel_of(robsim.Simulation(area=(300, 300), seed=1, control=control)) as (view, browser):
        browser.press("start")
        inside.wait(300)
        for i in range(300):
            browser.say("set", name="noise_level", value=i % 100)
            browser.say("inspect", k=0, path=[])
            browser.press("step")
            browser.say("hello", width=300)
            wait_for(lambda: browser.n_waiting < 100)
        assert "a callback is still busy" in browser.take("note")[0]["text"]
        assert view.driver.n_waiting < 200
        browser.press("pause")
        is_free.set()
        wait_for(lambda: not view.driver.n_waiting)
        assert view.driver.state == "paused"


def test_a_line_that_is_flooded_takes_no_room_from_others():
    inside, may_go_on = threading.Event(), threading.Event()
    with panel_of(robsim.Simulation(seed=1)) as (view, browser):
        other = FakeBrowser(view, name="other")
        view.post(lambda: (inside.set(), may_go_on.wait(300)))
        inside.wait(300)
        for _ in range(10_000):
            browser.say("animate", on=False)
        other.press("step")
        may_go_on.set()
        other.take("state", k=0)


@pytest.mark.long
def test_a_picture_of_any_width_comes_to_all():
    with panel_of(robsim.Simulation(seed=1)) as (view, browser):
        other = FakeBrowser(view, name="other")
        widths = [(kind, width) for kind in ("hello", "size") for width in (0, 2**31, 2**53 - 1)]
        for k, (kind, width) in enumerate(widths):
            browser.say(kind, width=width)
            browser.press("step")
            for one in (browser, other):
                assert one.take("frame", k=k)[1][0].startswith(b"\xff\xd8")


def test_names_of_columns_do_not_pile_up():
    with panel_of(robsim.Simulation(seed=1)) as (_, browser):
        for i in range(200):
            browser.say("columns", names=[f"{i} {j}" for j in range(100)])
        assert "groups of columns" in browser.take("note")[0]["text"]
        assert len(browser.rows) <= 100
        browser.press("step")
        browser.take("frame", k=0)


def test_there_are_not_too_many_pages(page):
    with ExitStack() as stack:
        clients = [stack.enter_context(greeted(page)) for _ in range(16)]
        with Client(page) as one_more:
            assert one_more.status == 503
        clients[0].line.close()
        wait_for(lambda: len(page.pages) == 15)
        stack.enter_context(greeted(page))


@pytest.mark.long
def test_many_half_open_requests_keep_no_page_out(page):
    held = []
    with greeted(page) as early:
        for i in range(thorough(1000, 100)):
            held.append(connected(page))
            held[-1].sendall(b"GET / HTTP/1.1\r\nHost: " + b"x" * (i % 3))
        assert request(page, f"/{page.secret}/view.js")[0] == 200
        with greeted(page) as late:
            for client in (early, late):
                client.say(type="press", button="step")
                assert client.hear("frame")
    for line in held:
        line.close()


@pytest.mark.long
def test_a_request_that_never_ends_is_ended(monkeypatch, page):
    monkeypatch.setattr("robsim.gui.hosts.serving._PATIENCE", 0.2)
    hasty = Page(page.view)
    for start in (b"", b"GET /", b"POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 9\r\n\r\n1"):
        with connected(hasty) as line:
            line.sendall(start)
            while line.recv(4096):
                pass
    hasty.close()


def test_noise_in_place_of_a_request(page):
    for size in (100, 1 << 14, 1 << 20):
        noise = random.Random(size).randbytes(size)
        with connected(page) as line, suppress(OSError):  # closed, and the rest not read
            line.sendall(noise)
            line.shutdown(socket.SHUT_WR)
            while line.recv(4096):
                pass
    assert request(page, f"/{page.secret}/")[0] == 200


def test_noise_in_place_of_frames(page):
    with greeted(page) as other:
        for seed in range(20):
            with greeted(page) as client:
                client.line.sendall(random.Random(seed).randbytes(2000))
                client.line.shutdown(socket.SHUT_WR)
        other.say(type="press", button="step")
        assert other.hear("frame")
