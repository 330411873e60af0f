"""The tabs with callbacks, with a step as a tree, and with the estimate; with a fake host."""

import io

import pytest
from PIL import Image

from fake_host import STATE
from waiting import wait_for

pytestmark = pytest.mark.slow

ASK_GAP = 200  # ms, as in inspector.js
FILE = "/home/ann/lesson.py"
ERROR = {"text": "ValueError: the pose is upside down", "line": 44, "k": 212}


def slot(kind, *, when="step", owner="default", **fields):
    facts = {"slot": kind, "when": when, "owner": owner, "name": f"default_{kind}", "file": None}
    facts |= {"line": None, "link": None, "can_edit": False, "ms": None, "calls": 0, "error": None}
    return facts | fields


SLOTS = [
    slot("define_model", when="once"),
    slot("measure", ms=0.5, calls=212),
    slot("estimate_state", owner="mine", file=FILE, line=41, can_edit=True, ms=2.0, error=ERROR),
    slot("control", owner="off", name=None),
]


@pytest.fixture
def tab_of(open_fake):
    """Return a function that shows a tab; the host."""

    def show(name, **options):
        host = open_fake(**options)
        host.setup()
        host.state(k=212, steps=213)
        host.frame(212)
        host.tab.click(f"button[role=tab][value={name}]")
        host.emit({"type": "callbacks", "slots": SLOTS})
        return host

    return show


def node(name, *, text="1", kind="number", more=False):
    return {"name": name, "text": text, "kind": kind, "more": more}


def tell_tree(host, path, *nodes, k=212):
    host.emit({"type": "tree", "k": k, "path": path, "nodes": nodes})


def test_tabs_that_need_something_are_offered_once_it_is_there(open_fake):
    host = open_fake()

    def names():
        return [tab.get_attribute("value") for tab in host.tab.get_by_role("tab").all()]

    assert not {"scenario", "scores"} & set(names())
    host.setup(has_options=True)
    wait_for(lambda: "scenario" in names())
    assert "scores" not in names()
    host.setup(challenge={"title": "Park", "steps": 150, "slots": ["control"]})
    wait_for(lambda: "scores" in names())
    assert "scenario" not in names()


def wait_sent(host, kind, count=1):
    wait_for(lambda: len(host.sent(kind)) >= count)
    return host.sent(kind)


def test_callbacks_stand_in_two_groups_with_owner_place_and_time(tab_of):
    host = tab_of("callbacks")
    once, each = (
        group.inner_text() for group in host.tab.locator(".robsim-callbacks ol").all()[:2]
    )
    assert "default_define_model" in once
    assert "default_measure" in each
    for words in ("yours", "lesson.py:41", "2.00 ms", "off"):
        assert words in each


def test_the_running_callback_is_yellow(tab_of):
    host = tab_of("callbacks")
    host.tab.check("input[name=animate]")
    assert host.sent("animate") == [{"type": "animate", "on": True}]
    host.state(k=212, steps=213, state="running", animate=True)
    host.emit({"type": "stages", "stage": "measure"})
    running = host.tab.locator("[aria-current=step]")
    assert "default_measure" in running.inner_text()
    host.emit({"type": "stages", "stage": "send"})
    assert running.count() == 0
    host.emit({"type": "stages", "stage": "estimate_state"})
    assert "lesson.py" in running.inner_text()


def test_edit_asks_python_or_is_a_link(tab_of):
    host = tab_of("callbacks")
    error = host.tab.locator(".robsim-slot-error >> visible=true")
    for words in ("212", "44", "ValueError: the pose is upside down"):
        assert words in error.inner_text()
    host.tab.click("button[name=edit_estimate_state]")
    assert host.sent("edit") == [{"type": "edit", "slot": "estimate_state"}]
    linked = [{**one, "link": "http://robsim.test/lab"} if one["file"] else one for one in SLOTS]
    host.emit({"type": "callbacks", "slots": linked})
    assert not host.tab.is_visible("button[name=edit_estimate_state]")
    link = host.tab.locator(".robsim-slot a >> visible=true")
    assert link.get_attribute("href") == "http://robsim.test/lab"


def test_a_source_shows_the_line_that_failed(tab_of):
    host = tab_of("callbacks")
    host.tab.click("button[name=source_estimate_state]")
    assert host.sent("source") == [{"type": "source", "slot": "estimate_state"}]
    text = "def f(step):\n    a = 1\n    b = 2\n    raise ValueError\n"
    message = {"type": "source", "slot": "estimate_state", "text": text, "file": FILE, "first": 41}
    host.emit(message)
    assert host.tab.inner_text(".robsim-failed").strip() == "raise ValueError"
    host.tab.keyboard.press("Escape")
    assert not host.tab.is_visible(".robsim-source")
    assert host.tab.evaluate("document.activeElement.name") == "source_estimate_state"


def test_a_level_of_the_tree_is_asked_for_when_it_is_opened(tab_of):
    host = tab_of("inspector")
    assert wait_sent(host, "inspect")[0] == {"type": "inspect", "k": None, "path": []}
    measurement = node("measurement", kind="object", more=True)
    tell_tree(host, [], node("k"), measurement, node("blobs", kind="dict", more=True))
    host.tab.focus("[role=treeitem][tabindex='0']")
    for key in ["ArrowDown", "ArrowRight"]:
        host.tab.keyboard.press(key)
    assert host.sent("inspect")[-1] == {"type": "inspect", "k": None, "path": ["measurement"]}
    tell_tree(host, ["measurement"], node("pose", text="[1, 2, 3]", kind="array"))
    host.tab.keyboard.press("ArrowRight")
    assert host.tab.inner_text(".robsim-inspector-path") == "step.measurement.pose"
    host.tab.keyboard.press("ArrowLeft")
    host.tab.keyboard.press("ArrowLeft")
    assert not host.tab.get_by_text("[1, 2, 3]").is_visible()
    host.tab.keyboard.press("ArrowDown")
    host.tab.keyboard.press("ArrowRight")
    tell_tree(host, ["blobs"], node("red", kind="list"))
    host.tab.keyboard.press("ArrowRight")
    assert host.tab.inner_text(".robsim-inspector-path") == 'step.blobs["red"]'


def test_what_is_open_stays_open_and_is_asked_for_again(tab_of):
    host = tab_of("inspector")
    wait_sent(host, "inspect")
    tell_tree(host, [], node("measurement", kind="object", more=True))
    host.tab.click(".robsim-node")
    tell_tree(host, ["measurement"], node("pose", text="old"))
    host.rest(ASK_GAP)
    host.forget()
    steps = [STATE | {"k": k, "steps": k + 1} for k in range(213, 218)]
    host.tab.evaluate("steps => steps.forEach((step) => host.emit(step, []))", steps)
    host.frame(218)
    host.rest(2 * ASK_GAP)
    asked = [message["path"] for message in host.sent("inspect")]
    assert asked in ([[], ["measurement"]], [[], ["measurement"]] * 2)  # not with each step
    tell_tree(host, [], node("measurement", kind="object", more=True), k=218)
    tell_tree(host, ["measurement"], node("pose", text="new"), k=218)
    assert host.tab.get_by_text("new", exact=True).is_visible()
    assert not host.tab.get_by_text("old", exact=True).is_visible()


def figure():
    out = io.BytesIO()
    Image.new("RGB", (90, 30), "white").save(out, "PNG")
    return out.getvalue()


def test_finish_is_offered_and_its_result_shown(tab_of):
    host = tab_of("result", theme="dark")
    host.tab.click("button[name=finish_result]")
    assert host.sent("press") == [{"type": "press", "button": "finish"}]
    rows = [["a1X", 2.0, 2.1, 0.05, 1.9], ["b1X", 0.2, -0.4, 0.1, None]]
    message = {"type": "result", "rows": rows, "text": "from 213 steps", "verdict": "weak"}
    host.emit(message, [figure()])
    sheet = host.tab.inner_text(".robsim-result")
    for words in ("a1X", "2.1", "\u22120.4", "from 213 steps", "weak"):
        assert words in sheet
    far = [one.get_attribute("aria-label") for one in host.tab.locator(".robsim-deviation").all()]
    assert far[0].endswith("batch 2.0, online \u22122.0")
    assert far[1].endswith("batch \u22126.0, online \u2013")
    width = "image => image.decode().then(() => image.naturalWidth)"
    assert host.tab.locator(".robsim-result img").evaluate(width) == 90


def test_reset_removes_the_result_of_the_old_run(tab_of):
    host = tab_of("result")
    rows = [["a1X", 2.0, 2.1, 0.05, 1.9]]
    host.emit({"type": "result", "rows": rows, "text": "from 213 steps", "verdict": ""}, [])
    host.tab.wait_for_selector("text=from 213 steps")
    host.state(k=213, steps=214)
    assert "from 213 steps" in host.tab.inner_text(".robsim-result")
    host.state(k=-1, steps=0, resets=1)
    assert "from 213 steps" not in host.tab.inner_text(".robsim-result")
    assert host.tab.inner_text("button[name=finish_result]") == "Finish"


def test_deviations_need_a_truth_and_what_differs_by_rounding_is_exact(tab_of):
    host = tab_of("result")
    rows = [["a1X", 1.9375, 1.9375 - 1e-13, 1e-15, 1.9375], ["d1X", 0.0, 0.1, 1e-15, 0.0]]
    host.emit({"type": "result", "rows": rows, "text": "", "verdict": ""}, [])
    exact, far = (row.inner_text() for row in host.tab.locator(".robsim-result tbody tr").all())
    assert "exact" in exact
    assert "exact" not in far
    rows = [["a1X", None, 2.1, 0.05, 1.9]]
    host.emit({"type": "result", "rows": rows, "text": "", "verdict": ""}, [])
    assert host.tab.locator(".robsim-deviation").count() == 0


def test_a_task_has_a_tab_with_its_scores(open_fake):
    host = open_fake()
    host.setup(challenge={"title": "park", "steps": 60, "slots": ["control"]})
    score = {"points": 0.5, "stars": 1, "best": None, "by_hand": [], "changed": [], "rule": None}
    rows = [["time", "s", 3.0, 2.0, 1.5, "up to 2", "from 3"]]
    host.emit({"type": "score", "rows": rows, **score})
    host.tab.click("button[name='challenge.details']")
    assert host.tab.inner_text("[role=tab][aria-selected=true]") == "Score"
    cells = host.tab.locator(".robsim-scores tbody tr > *").all_inner_texts()
    assert cells == ["time (s)", "3", "2", "1.5", "up to 2", "from 3"]
    host.setup(challenge=None)
    assert host.tab.locator("[role=tab][value=scores]").count() == 0


def test_the_button_of_share_says_that_it_works(open_fake):
    host = open_fake()
    host.setup(can_share=True)
    host.state(k=1, steps=2)
    host.tab.click("button[name=share]")
    assert host.tab.is_disabled("button[name=sharing]")
    host.emit({"type": "note", "level": "error", "text": "it could not be made"})
    assert host.tab.is_enabled("button[name=share]")
