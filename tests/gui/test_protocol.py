"""PROTOCOL.md says what the code does."""

import re
from pathlib import Path

import numpy as np
import pytest

import robsim

GUI = Path(robsim.gui.__file__).parent
PLACES = [(300, 300), (2100, 300), (2100, 2100), (300, 2100)]
RUN, TOOLS = (GUI / "PROTOCOL.md").read_text("utf-8").split("## Tools\n")
TO_BROWSER, FROM_BROWSER = RUN.split("## From the browser")
TOOLS_TO, REST = TOOLS.split("### Tools, from the browser")
TOOLS_FROM, REST = REST.split("### Defining a robot")
ROBOTS, FLOOR = REST.split("### Calibrating a floor")
ROW = re.compile(r"^\| `(\w+)` \| (.*?) \|", re.MULTILINE)


def rows(text):
    return {name: set(re.findall(r"`(\w+)`", fields)) for name, fields in ROW.findall(text)}


def test_every_message_from_a_browser_stands_there_with_its_fields(user_folder):
    panels = {
        "": robsim.panel(robsim.Simulation(seed=1)),
        TOOLS_FROM: robsim.gui.color_panel(robot="lab"),
        TOOLS_FROM + ROBOTS: robsim.gui.robot_panel(robot="lab"),
        TOOLS_FROM + FLOOR: robsim.gui.floor_panel(),
    }
    for text, panel in panels.items():
        panel.close()
        messages, told = panel._view.messages, rows(FROM_BROWSER + text)
        assert set(messages) <= set(told)
        assert text or set(messages) == set(told)
        for kind, fields in messages.items():
            assert set(fields) <= told[kind], kind


def sent_by(folder, *without):
    files = [file for file in folder.rglob("*.py") if not set(without) & set(file.parts)]
    code = "".join(file.read_text("utf-8") for file in files)
    return {*re.findall(r'"type": "(\w+)"', code), *re.findall(r'_gathered\("(\w+)"\)', code)}


def test_every_message_to_a_browser_stands_there():
    told = rows(TO_BROWSER.split("`setup` may come again")[0])
    assert sent_by(GUI, "_tools") == {"setup", "state", *told}
    assert sent_by(GUI / "_tools") == set(rows(TOOLS_TO))


def test_every_field_of_the_state_of_a_robot_stands_there():
    with robsim.gui.robot_panel(robot="lab") as tool:
        told = set(re.findall(r"`(\w+)`", ROBOTS)) | rows(TOOLS_TO)["state"]
        assert set(tool._view._state()) - {"type"} <= told


@pytest.mark.long
def test_every_field_of_the_state_of_a_floor_stands_there():
    told = set(re.findall(r"`(\w+)`", FLOOR)) | rows(TOOLS_TO)["state"]
    with robsim.gui.floor_panel() as tool:
        tool.put([(230, 160), (569, 160), (634, 492), (165, 492)], PLACES)
        tool.fill(600)
        state = tool._view._state()
        told_too = [state[name] for name in ("grid", "fit", "sheets")]
        told_too += [state["points"][0], state["fit"]["points"][0]]
        for one in (state, *told_too):
            assert set(one) - {"type"} <= told
        assert set(tool._view.lens.message()) - {"type"} <= rows(TOOLS_TO)["board"]


def test_every_field_of_what_a_tool_tells_stands_there():
    told = rows(TOOLS_TO)
    with robsim.gui.color_panel(np.full((9, 9, 3), 90, np.uint8)) as tool:
        assert set(tool._view._state()) - {"type"} <= told["state"]
        tool._view.picture = tool._view.source.at(0)
        head, _ = tool._view.head(tool._view.picture)
        assert set(head) <= told["frame"]


def test_every_field_of_what_a_panel_tells_stands_there():
    with robsim.panel(robsim.Simulation(area=(300, 300), seed=1)) as panel:
        for kind in ("setup", "state"):
            fields = panel._view._gathered(kind)
            about = rf"^`{kind}`(,| may come).*?\n\n"
            told = re.search(about, TO_BROWSER, re.MULTILINE | re.DOTALL)[0]
            told = set(re.findall(r"`\w+`", told))
            assert {f"`{name}`" for name in fields if name != "type"} <= told
