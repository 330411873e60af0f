"""PROTOCOL.md says what the code does."""

import re

import pytest

import robsim
from robsim.gui._hosts.script import STATIC
from robsim.gui._panel.messages import MESSAGES
from robsim.gui._panel.view import PanelView

GUI = STATIC.parent
TO_BROWSER, FROM_BROWSER = (GUI / "PROTOCOL.md").read_text("utf-8").split("## From the browser")
ROW = re.compile(r"^\| `(\w+)` \| (.*?) \|", re.MULTILINE)


def rows(text):
    return {name: set(re.findall(r"`(\w+)`", fields)) for name, fields in ROW.findall(text)}


def test_every_message_from_a_browser_stands_there_with_its_fields():
    told = rows(FROM_BROWSER)
    assert set(told) == set(MESSAGES)
    for kind, fields in MESSAGES.items():
        assert set(fields) <= told[kind], kind


def test_every_message_to_a_browser_stands_there():
    code = "".join(file.read_text("utf-8") for file in GUI.rglob("*.py"))
    sent = {*re.findall(r'"type": "(\w+)"', code), *re.findall(r'_gathered\("(\w+)"\)', code)}
    assert sent == {"setup", "state", *rows(TO_BROWSER.split("`setup` may come again")[0])}


@pytest.mark.parametrize("kind", ["setup", "state"])
def test_every_field_of_what_a_panel_tells_stands_there(kind):
    view = PanelView(robsim.Simulation(area=(300, 300), seed=1))
    fields = view._gathered(kind)
    view.close()
    told = re.search(rf"^`{kind}`(,| may come).*?\n\n", TO_BROWSER, re.MULTILINE | re.DOTALL)[0]
    assert {f"`{name}`" for name in fields if name != "type"} <= set(re.findall(r"`\w+`", told))
