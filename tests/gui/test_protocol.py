"""PROTOCOL.md says what the code does."""

import re
from pathlib import Path

import robsim

GUI = Path(robsim.gui.__file__).parent
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
    assert sent_by(GUI, "tools") == {"setup", "state", *told}
    assert sent_by(GUI / "tools") == set(rows(TOOLS_TO))


def test_every_field_of_the_state_of_a_tool_stands_there(user_folder):
    gui = robsim.gui
    for make, text in ((gui.color_panel, ""), (gui.robot_panel, ROBOTS), (gui.floor_panel, FLOOR)):
        with make() as tool:
            told = set(re.findall(r"`(\w+)`", text)) | rows(TOOLS_TO)["state"]
            assert set(tool._view._state()) - {"type"} <= told


def test_every_field_of_what_a_panel_tells_stands_there():
    with robsim.panel(robsim.Simulation(area=(300, 300), seed=1)) as panel:
        for kind in ("setup", "state"):
            fields = panel._view._gathered(kind)
            about = rf"^`{kind}`(,| may come).*?\n\n"
            told = re.search(about, TO_BROWSER, re.MULTILINE | re.DOTALL)[0]
            told = set(re.findall(r"`\w+`", told))
            assert {f"`{name}`" for name in fields if name != "type"} <= told
