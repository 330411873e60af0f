"""Messages of the browser, and PROTOCOL.md about them."""

import json
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import robsim
from fuzzing import fuzzed
from robsim.gui import _link as _messages
from robsim.gui._link import Refused
from robsim.gui.panels.part import MESSAGES
from robsim.gui.start.host import Start

# --- messages


def checked_message(message):
    return _messages.checked_message(message, MESSAGES)


GOOD = [
    {"type": "hello", "id": "a", "width": 600},
    {"type": "grant", "id": "a", "upto": 15, "late": False},
    {"type": "set", "id": "a", "name": "speed", "value": 2.5},
    {"type": "set", "id": "a", "name": "noise", "value": "gaussian"},
    {"type": "set", "id": "a", "name": "boxes", "value": True},
    {"type": "set_option", "id": "a", "name": "area", "value": [[1.5, None], {"x": True}, "y"]},
    {"type": "load_scenario", "id": "a", "text": "x" * 1000},
    {"type": "go_to", "id": "a", "x": 1, "y": -2.5},
    {"type": "path", "id": "a", "points": [[0, 1], [2.5, 3]]},
    {"type": "look", "id": "a", "k": None},
    {"type": "look", "id": "a", "k": 3},
    {"type": "magnify", "id": "a", "at": [1, 2.5], "half": 30, "glass": 0},
    {"type": "columns", "id": "a", "names": ["u"]},
    {"type": "animate", "id": "a", "on": True},
]


def test_what_is_taken():
    for message in GOOD:
        checked = checked_message({**message, "more": "is left out"})
        assert json.loads(json.dumps(checked)) == message


def test_what_is_no_message():
    for message in (None, 3, "text", [], {}, {"type": None}, {"type": []}, {"type": "x"}, [{}]):
        with pytest.raises(Refused, match="not a message"):
            checked_message(message)


NESTED = []
for _ in range(10_000):
    NESTED = [NESTED]
NUMBERS = [None, "1", True, [], {}, float("nan"), float("inf"), 10**400, -(10**400)]
WHOLE = [*NUMBERS, -1, 2**53, 1.5]
TEXTS = [None, 1, [], {}, "x" * 201, NESTED]
BAD = {
    ("hello", "width"): WHOLE,
    ("grant", "upto"): WHOLE,
    ("grant", "late"): [None, 0, 1, "true"],
    ("press", "button"): TEXTS,
    ("set", "value"): [None, [], {}, float("nan"), 10**400, "x" * 201, NESTED],
    ("set_option", "value"): [float("nan"), {"x": float("inf")}, "x" * 1_000_001, NESTED],
    ("load_scenario", "text"): ["x" * 1_000_001],
    ("go_to", "x"): NUMBERS,
    ("path", "points"): [
        *(None, 1, "ab", {}, [1], [[1]], [[1, 2, 3]], [[1, "2"]], [[1, float("nan")]], NESTED),
        *([[0, 0]] * 1001, [0] * 10**6, [[[0] * 10**6, 1]], [NESTED]),
    ],
    ("look", "k"): [k for k in WHOLE if k is not None],
    ("magnify", "half"): WHOLE,
    ("columns", "names"): [None, "u", {}, ["u"] * 101, [None], [["u"]], ["u"] * 10**6],
    ("animate", "on"): [None, 0, "on"],
    ("bye", "id"): TEXTS,
}


def test_a_field_of_another_kind_is_named():
    goods = {message["type"]: message for message in GOOD}
    for (kind, field), values in BAD.items():
        for value in values:
            with pytest.raises(Refused, match=rf"\b{field}\b.*\b{kind}\b") as refused:
                checked_message({"type": kind, "id": "a", **goods.get(kind, {}), field: value})
            assert len(str(refused.value)) < 200


def test_a_field_that_is_missing_is_named():
    for message in GOOD:
        for field in message.keys() - {"type"}:
            with pytest.raises(Refused, match=rf"\b{field}\b"):
                checked_message({name: value for name, value in message.items() if name != field})


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=6,
)
FIELDS = sorted({field for fields in MESSAGES.values() for field in fields} | {"id"})


@pytest.mark.fuzz
@fuzzed
@given(st.sampled_from(sorted(MESSAGES)), st.dictionaries(st.sampled_from(FIELDS), JSON))
def test_anything_is_taken_or_refused(kind, fields):
    try:
        checked = checked_message({"type": kind, **fields})
    except Refused:
        return
    assert checked.keys() == {"type", "id", *MESSAGES[kind]}
    json.dumps(checked, allow_nan=False)


# --- PROTOCOL.md


GUI = Path(robsim.gui.__file__).parent
RUN, TOOLS = (GUI / "PROTOCOL.md").read_text("utf-8").split("## Tools\n")
TO_BROWSER, FROM_BROWSER = RUN.split("## From the browser")
TOOLS_TO, REST = TOOLS.split("### Tools, from the browser")
TOOLS_FROM, REST = REST.split("### Defining a robot")
ROBOTS, REST = REST.split("### Calibrating a floor")
FLOOR, START = REST.split("## The start page")
ROW = re.compile(r"^\| `(\w+)` \| (.*?) \|", re.MULTILINE)


def rows(text):
    return {name: set(re.findall(r"`(\w+)`", fields)) for name, fields in ROW.findall(text)}


def test_every_message_from_a_browser_stands_there_with_its_fields(user_folder):
    panels = {
        "": robsim.panel(robsim.Simulation(seed=1)),
        TOOLS_FROM: robsim.gui.color_panel(robot="lab"),
        TOOLS_FROM + ROBOTS: robsim.gui.robot_panel(robot="lab"),
        TOOLS_FROM + FLOOR: robsim.gui.floor_panel(),
        START: Start(),
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
