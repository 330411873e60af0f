"""The start page: its cards open panels on the same page, and it comes back."""

import subprocess
import sys
from contextlib import contextmanager

import pytest

from browsers import FakeBrowser
from page_client import Client, request
from robsim.gui.start.cards import film_of
from robsim.gui.start.host import Start
from robsim.gui.start.view import CARDS
from small_runs import robsim_threads
from waiting import wait_for


@pytest.fixture
def start(monkeypatch):
    """A start page without films."""
    monkeypatch.setattr("robsim.gui.start.view.StartView._film", lambda view: None)
    with Start() as opened:
        yield opened
    wait_for(lambda: not robsim_threads())


@contextmanager
def told(page):
    """A browser that has said hello."""
    with Client(page) as client:
        client.say(type="hello", width=100)
        yield client


def kind_of(page):
    return request(page, f"/{page.secret}/")[2].decode().partition('data-kind="')[2].split('"')[0]


def test_a_card_opens_its_panel_on_the_same_page_and_the_way_back_keeps_it(start):
    page = start._serve()
    with told(page) as client:
        assert client.hear("setup")[0]["kept"] == ""
        client.say(type="open", card="drive")
        client.hear("moved")
    assert kind_of(page) == "panel"
    first = start.panel
    with told(page) as client:
        assert client.hear("setup")[0]["has_home"]
        wait_for(lambda: len(first.trace) > 2)
        client.say(type="home")
        client.hear("moved")
    assert kind_of(page) == "start"
    wait_for(lambda: first.state == "paused")
    with told(page) as client:
        assert client.hear("setup")[0]["kept"] == str(len(first.trace))
        client.say(type="resume")
        client.hear("moved")
        assert kind_of(page) == "panel"
    with Client(page, path=f"/{page.secret}/socket?kind=start") as away:  # when the page moved
        away.hear("moved")
    assert start.panel is first
    start._open_card("task")
    assert (first.state, start.panel.state) == ("closed", "paused")


def test_what_cannot_be_opened_is_said(start, monkeypatch):
    browser = FakeBrowser(start._view)
    browser.say("open", card="nothing")
    assert "must be one of" in browser.take("note", level="error")[0]["text"]

    def fail(card):
        raise OSError("no port is free")

    monkeypatch.setattr("robsim.gui.start.cards.scene_of", fail)
    browser.say("open", card="drive")
    browser.take("refused")
    assert browser.take("note", level="error")[0]["text"] == "no port is free"


@pytest.mark.slow
@pytest.mark.parametrize("card", CARDS)
def test_each_card_opens_moves_and_has_a_film(start, card):
    start._open_card(card)
    if card != "task":  # which waits for its player
        wait_for(lambda: start._panel._view.record.n_steps > 3)
    assert start.panel.error is None
    head, pictures = film_of(card)
    assert len(head["measured"]) == head["every"] * len(pictures)
    assert any(head["measured"])
    assert bool(head["errors"]) == (card == "identify")
    assert any(head["estimated"]) == (card == "estimate")


def test_the_page_comes_before_what_a_run_needs():
    code = "import sys, robsim.cli.simulated.start, robsim.gui.start.host, robsim.gui.hosts.page\n"
    code += "print({'numpy', 'robsim._core', 'PIL', 'matplotlib'} & {*sys.modules})"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout == "set()\n"
