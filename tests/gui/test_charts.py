"""The traces and the parameters in a browser, with a fake host."""

import numpy as np
import pytest

from panel_mouse import Chart
from robsim.trace import PARAMETER_NAMES
from waiting import wait_for

pytestmark = pytest.mark.slow


def walk(n, seed=16):
    """Return the columns of a robot that drives around, and is lost in ten steps."""
    rng = np.random.default_rng(seed)
    truth = np.array([600, 600, 0]) + np.cumsum(rng.normal(0, [1, 1, 0.02], (n, 3)), axis=0)
    measured = truth + rng.normal(0, [0.5, 0.5, 0.02], (n, 3))
    measured[20:30] = np.nan
    held = measured.copy()
    held[20:30] = measured[19]
    return {"pose_true": truth, "pose_measured": measured, "pose_held": held}


POSE = ["x", "y", "heading"]
NAMES, BLOBS = list(PARAMETER_NAMES), ["x_1", "y_1", "x_2", "y_2"]
FIELDS = {
    **dict.fromkeys(("pose_true", "pose_measured", "pose_held", "pose_estimated"), POSE),
    **{"u": ["u1", "u2"], "covariance": [f"c{i}" for i in range(9)]},
    **{"parameters": NAMES, "standard_errors_unscaled": NAMES},
    **{"blobs_red": BLOBS, "blobs_blue": BLOBS},
}
COLUMNS = [{"name": n, "fields": f, "units": [""] * len(f)} for n, f in FIELDS.items()]


@pytest.fixture
def show(open_fake):
    """Return a function that shows some rows in a tab."""

    def show_it(rows, tab="traces", setup=None):
        host = open_fake(choices={"tab": tab, "overlays": {"object_trace": False}})
        host.setup(columns=COLUMNS, **(setup or {}))
        host.state()
        host.rows(rows)
        settle(host)
        return host

    return show_it


def settle(host):
    """Wait until sizes, sight and paints have come to rest."""
    for _ in range(4):
        host.paint()


def follows(host):
    follow = host.tab.locator("button[name=follow]:visible")
    return follow.get_attribute("aria-pressed") == "true"


def wanted(host):
    return {name for message in host.sent("columns") for name in message["names"]}


def looks(host):
    return [message["k"] for message in host.sent("look")]


def test_only_what_the_visible_tab_needs_is_asked_for(show):
    host = show({})
    assert {"pose_true", "pose_measured", "covariance"} <= wanted(host)
    assert not {"parameters", "blobs_red"} & wanted(host)
    host.tab.click("[name=objects]")
    host.tab.click("role=tab[name=Parameters]")
    settle(host)
    assert {"blobs_red", "blobs_blue", "parameters", "standard_errors_unscaled"} <= wanted(host)


def test_an_outlier_among_many_rows_is_drawn(show):
    truth = walk(20_000)["pose_true"]
    truth[:, 0] = 600 + np.sin(np.arange(20_000) / 1000)
    truth[8642, 0] = 900
    host = show({"pose_true": truth[:10]})
    host.tab.select_option("select[name=window]:visible", "0")
    host.rows({"pose_true": truth})
    settle(host)
    inked = Chart(host, "x px").inked("true")
    columns = np.flatnonzero(inked[: inked.shape[0] // 2].any(axis=0))
    assert 1 <= len(columns) <= 2
    left, right = 44, inked.shape[1] - 9
    assert columns[0] == pytest.approx(left + 0.4321 * (right - left), abs=2)


@pytest.mark.parametrize("n", [300, 20_000])
def test_a_heading_that_goes_round_is_broken_not_crossed_out(show, n):
    heading = np.arange(n) / n * 4 * np.pi
    host = show(
        {"pose_true": np.stack([0 * heading, 0 * heading, np.angle(np.exp(1j * heading))], 1)}
    )
    host.tab.select_option("select[name=window]:visible", "0")
    settle(host)
    inked = Chart(host, "heading").inked("true")[22:-22]
    assert inked.mean(axis=0).max() < 0.15  # of each column
    assert inked[:, 60:-60].any(axis=0).mean() > (0.9 if n > 300 else 0.5)


def test_wheel_zooms_about_the_pointer_and_holds_and_a_double_click_follows(show):
    host = show(walk(600))
    chart = Chart(host, "x px")
    before, _ = chart.read(0.25)
    assert before == pytest.approx(150, abs=1)
    assert follows(host)
    for _ in range(8):
        host.tab.mouse.wheel(0, -100)
        host.paint()
    assert not follows(host)
    assert chart.read(0.25)[0] == pytest.approx(before, abs=1)
    assert 160 < chart.read(0.75)[0] < 250
    host.tab.mouse.dblclick(*chart.at(0.5))
    wait_for(lambda: chart.read(0.5)[0] == pytest.approx(300, abs=1))
    assert follows(host)


def test_a_drag_pans_all_charts(show):
    host = show(walk(2000))
    chart = Chart(host, "x px")
    host.tab.mouse.move(*chart.at(0.5))
    host.tab.mouse.down()
    host.tab.mouse.move(*chart.at(0.75), steps=5)
    host.tab.mouse.up()
    host.paint()
    assert looks(host) == []
    # 1400 to 1999 were shown.
    assert Chart(host, "\u0394y").read(0.5)[0] == pytest.approx(1700 - 150, abs=4)


def test_a_click_shows_the_frame_and_one_near_a_black_dot_that_of_the_dot(show):
    rows = walk(100)
    for name in rows:
        rows[name][:, 0] = 600
    rows["pose_measured"][20:30] = np.nan
    rows["pose_held"][24, 0] = 700
    host = show(rows)
    chart = Chart(host, "x px")
    host.tab.mouse.click(*chart.at(0.7))
    dot = np.flatnonzero(chart.inked("held").any(axis=1))[0]  # the highest one
    host.tab.mouse.click(chart.at(0.255)[0], chart.over.bounding_box()["y"] + float(dot) + 3)
    assert looks(host) == [70, 24]


def test_one_cursor_goes_through_time_line_numbers_and_charts(show):
    host = show(walk(2000))
    host.state(state="running", k=1999, steps=2000)
    host.frame(1990, rows=walk(2000))
    settle(host)
    place = host.tab.locator(".robsim-timeline-place")
    step = host.tab.locator(".robsim-title-step")
    assert (place.inner_text(), step.inner_text()) == ("1990 / 1990", "step 1990")
    assert "step 1990 " in Chart(host, "x px").key("End")
    host.tab.evaluate("document.activeElement.blur()")
    slider = host.tab.locator("input[name=timeline]")
    slider.fill("300")
    settle(host)
    assert looks(host) == [300]
    assert not follows(host)
    assert step.inner_text() == "step 300"
    for label in ("x px", "\u0394heading"):  # scrolled to it, with a line at it
        assert Chart(host, label).marked() == pytest.approx(0.5, abs=0.02)
    host.tab.locator("button[name=follow]:visible").click()
    settle(host)
    assert looks(host) == [300, None]
    assert follows(host)


def test_a_click_moves_no_chart_of_a_long_run(show):
    host = show(walk(2000))
    host.state(state="paused", k=1999, steps=2000)
    settle(host)
    chart = Chart(host, "x px")
    host.tab.mouse.click(*chart.at(0.4))
    settle(host)
    assert looks(host) == [pytest.approx(1640, abs=3)]
    host.tab.mouse.move(5, 5)  # the pointer's own line covers the mark
    settle(host)
    assert chart.marked() == pytest.approx(0.4, abs=0.02)


def test_keys_move_the_cursor_and_say_what_is_there(show):
    host = show(walk(600))
    chart = Chart(host, "x px")
    assert chart.key("End").startswith("step 599 ")
    said = chart.key("ArrowLeft", "Shift+ArrowLeft")
    assert said.startswith("step 588 ")
    assert "measured" in said
    assert chart.key("Home", "ArrowRight").startswith("step 1 ")
    chart.key("Enter", "+")
    assert not follows(host)
    chart.key("Escape")
    assert follows(host)
    assert looks(host) == [1, None]


def test_a_column_that_was_added_is_kept(show):
    host = show(walk(100))
    host.tab.select_option("select[name=add_column]", "u2")
    host.rows({"u": np.ones((100, 2))})
    settle(host)
    assert "u" in wanted(host)
    assert "u2 1.000" in Chart(host, "u2").key("End")
    host.load()
    host.setup(columns=COLUMNS)
    host.state()
    settle(host)
    assert Chart(host, "u2").over.is_visible()


def test_after_a_reset_nothing_old_is_left(show):
    host = show(walk(500))
    chart = Chart(host, "x px")
    chart.read(0.5)
    for rows, is_inked in (({n: b[:0] for n, b in walk(50).items()}, False), (walk(50), True)):
        host.rows(rows)
        host.paint()
        assert chart.inked("true").any() == is_inked
        assert host.tab.locator(".robsim-tip").is_hidden()


def test_without_truth_the_inputs_stand_in_place_of_the_errors(show):
    host = show({"u": np.ones((100, 2))}, setup={"has_truth": False})
    assert "u" in wanted(host)
    assert Chart(host, "\u0394x").over.count() == 0
    for label in ("u1", "u2", "interval"):
        assert Chart(host, label).over.is_visible()
    assert host.tab.locator("button[name=show_true]").is_hidden()


def test_parameters_are_drawn_with_truth_excitation_and_a_robust_range(show):
    rng = np.random.default_rng(3)
    values = 1.9 + rng.normal(0, 0.01, (600, 15))
    values[:5] = 1e5
    spread = np.tile(1 / np.sqrt(1 + np.arange(600))[:, np.newaxis], (1, 15))
    rows = {"parameters": values, "standard_errors_unscaled": spread}
    host = show(rows, "parameters", {"theta_true": [1.9375] * 15})
    told = {"names": NAMES, "values": values[-1].tolist(), "errors": [0.01] * 15}
    excitation = {"text": "b1 is hardly excited", "good": False, "weak": ["b1X"]}
    host.emit({"type": "parameters", **told, "excitation": excitation})
    settle(host)
    assert host.tab.locator("canvas[role=slider]:visible").count() == 15
    assert host.tab.locator(".robsim-verdict").inner_text() == "b1 is hardly excited"
    chart = Chart(host, "a1X")
    assert chart.count("true") > 20
    line = chart.inked("estimated")
    assert np.flatnonzero(line.any(axis=1)).size > 40  # not squashed by the first steps
    assert "\u00b1 0.010" in chart.key("End")


def test_ghosts_are_read_off_and_the_nees_has_a_meter(show):
    host = show(walk(300))
    ghost = np.zeros((300, 6), "<f4")
    ghost[:, 0] = 700
    host.emit({"type": "ghosts", "names": ["mine"]}, [ghost.tobytes()])
    settle(host)
    assert "mine" in Chart(host, "x px").read(0.5)[1]
    host.tab.click("button[name=keep]")
    host.tab.select_option("select[name=compare]", "reference")
    host.tab.click("button[name=drop_mine]")
    said = [host.sent(kind) for kind in ("keep", "reference", "drop_ghost")]
    assert said == [
        [{"type": "keep"}],
        [{"type": "reference"}],
        [{"type": "drop_ghost", "name": "mine"}],
    ]
    with host.tab.expect_file_chooser() as chooser:
        host.tab.select_option("select[name=compare]", "file")
    chooser.value.set_files({"name": "other.npz", "mimeType": "", "buffer": b"run"})
    wait_for(lambda: [part["name"] for part in host.sent("upload")] == ["other.npz"])
    told = {"mean": 9.0, "n": 30, "band": [2.2, 3.9], "verdict": "optimistic"}
    statistics = {"type": "statistics", "first": 0, "last": 299, "errors": []}
    host.emit({**statistics, "nees": told})
    meter = host.tab.get_by_role("meter")
    assert meter.get_attribute("aria-valuenow") == "9"
    host.emit({**statistics, "nees": None})
    assert meter.is_hidden()
