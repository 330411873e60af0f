"""The figures of the manual of 2008, reproduced with the mouse: what they show, with numbers."""

import math
import re

import numpy as np
import pytest

import robsim
from panel_mouse import INKS, Mouse, number
from robsim.trace import PARAMETER_NAMES
from waiting import wait_for

pytestmark = pytest.mark.slow

TIMES_100 = 16  # of the speeds
#: As the manual prints them.
TRUE_VALUES = {
    **{"a1X": 1.9375, "a2X": -0.9375, "b1X": 0.20833, "b2X": 0.20833, "d1X": 8.3333e-6},
    **{"a1Y": 1.9375, "a2Y": -0.9375, "b1Y": 0.20833, "b2Y": 0.20833, "d1Y": 8.3333e-6},
    **{"a1P": 1.8333, "a2P": -0.83333, "b1P": 0.030556, "b2P": -0.030556, "d1P": 0},
}
STEP_ORDER = ["Evaluate the model", "Estimate parameters", "Measure", "Control"]


@pytest.fixture
def mouse(open_panel):
    """The panel of a simulation as it is by default: the robot spins, and nothing is on."""
    mouse = Mouse(*open_panel(robsim.Simulation(robot="lab", seed=1)))
    mouse.tab.set_default_timeout(10_000)  # ms
    mouse.slide("Speed", TIMES_100)
    return mouse


def longest_record(seen):
    """Return the length of the longest run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], seen.astype(int), [0]])))
    return int((edges[1::2] - edges[::2]).max(initial=0))


def wait_for_histograms(mouse):
    """Wait until they are those of the whole record; return n, mean and std of each."""
    n = longest_record(mouse.view.record.trace.seen)

    def of_all():
        found = [mouse.histogram(name) for name in ("x", "y", "heading")]
        return all(one and one[0] == n for one in found) and found

    return wait_for(of_all)


def test_2_1_the_robot_before_the_start(mouse):
    picture = mouse.picture().astype(float)
    side = len(picture)

    def mean(x, y, half=4):
        column, row = round(side * x / 1200), round(side * y / 1200)
        return picture[row - half : row + half + 1, column - half : column + half + 1].mean((0, 1))

    red, green, blue = mean(600, 92)
    assert red > 2 * max(green, blue)  # what the default callback draws on the background
    darker = np.median(picture[:, round(side * 0.68) : round(side * 0.72)])
    brighter = np.median(picture[:, round(side * 0.61) : round(side * 0.65)])
    assert darker / brighter == pytest.approx(0.8, abs=0.05)
    marker = mean(586, 578, 2)
    assert marker[2] > 1.5 * marker[0]  # the blue one, to the left of a robot that looks right
    over = mouse.tab.evaluate(
        """(() => {
          const box = document.querySelector(".robsim-camera").getBoundingClientRect();
          const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
          return document.elementFromPoint(x, y).tagName;
        })()"""
    )
    assert over == "CANVAS"  # nothing hides the robot
    assert mouse.tab.inner_text(".robsim-title-step") == "step 0"
    mouse.press("step")  # from now on the true pose is known
    wait_for(lambda: mouse.n_steps == 1)
    mouse.show("truth")
    left, right, middle = (round(side * at / 1200) for at in (649, 659, 600))
    ahead = mouse.picture()[middle - 2 : middle + 3, left:right]  # of the robot, where it looks
    assert (np.abs(ahead - INKS["true"]).max(axis=2) < 60).any()


def test_2_2_traces_of_a_robot_that_spins(mouse):
    mouse.run(40)
    charts = [mouse.chart(label) for label in ("x px", "y px", "heading")]
    for chart in charts:
        assert chart.count("true") > 50
        assert chart.count("measured") == chart.count("held") == 0
    mouse.choose("Tracking", "Default")
    mouse.run(360)
    (n, mean_x, std_x), _, (_, _, std_heading) = wait_for_histograms(mouse)
    assert 350 < n <= mouse.n_steps - 40
    for chart in charts:
        assert chart.count("true") > 50
        assert chart.count("measured") > 50
        assert chart.count("held") == 0
    # The offset of the markers goes round with the robot.
    assert abs(mean_x) < 0.1
    assert std_x < 0.1
    # One of 36 headings is shown: the error is a saw-tooth of 10 degrees.
    assert std_heading == pytest.approx(10 / math.sqrt(12), abs=0.1)
    errors = mouse.chart("\u0394heading")
    mouse.tab.select_option("select[name=window]:visible", "200")
    readings = dict(errors.read(0.5 + i / 200) for i in range(40))
    read = {k: number(names["measured"]) for k, names in readings.items()}
    assert max(map(abs, read.values())) < 5.3
    jumps = [read[k + 1] - read[k] for k in read if k + 1 in read]
    assert len(jumps) > 30
    ramps, steps = ([j for j in jumps if (j > 5) == is_step] for is_step in (False, True))
    assert np.mean(ramps) == pytest.approx(-1, abs=0.1)
    assert 3 <= len(steps) <= 5
    assert np.mean(steps) == pytest.approx(9, abs=0.3)


def parameters_shown(mouse):
    """Return what is read off at the newest step in each of the 15 charts, and what is weak."""
    charts = {name: mouse.chart(name) for name in PARAMETER_NAMES}
    assert all(chart.count("true") > 8 for chart in charts.values())  # the crosses
    assert all(chart.count("estimated") > 20 for chart in charts.values())
    return {name: number(chart.read(0.995)[1]["estimate"]) for name, chart in charts.items()}


def not_excited(verdict):
    """Return how many parameters are said not to be excited."""
    found = re.search(r"(\d+) not excited", verdict.inner_text())
    return int(found[1]) if found else 0


def test_2_3_and_2_4_the_online_estimate_needs_a_robot_that_drives(mouse):
    mouse.choose("Parameter estimation", "Default")
    mouse.open("Parameters")
    mouse.run(100)
    verdict = mouse.tab.locator(".robsim-verdict")
    wait_for(lambda: not_excited(verdict) >= 9)  # all of x and y but the decay
    spinning = parameters_shown(mouse)
    far = [name for name, true in TRUE_VALUES.items() if abs(spinning[name] - true) > 0.01]
    assert len(far) >= 8
    mouse.tab.get_by_label("Robot drives").select_option("drive-around")
    mouse.run(300)
    wait_for(lambda: not_excited(verdict) == 0)
    for name, value in parameters_shown(mouse).items():
        assert value == pytest.approx(TRUE_VALUES[name], abs=2e-3), name


def test_2_5_the_batch_estimate_at_the_end(mouse):
    mouse.tab.get_by_label("Robot drives").select_option("drive-around")
    mouse.choose("Parameter estimation", "Default")
    mouse.press("start")
    wait_for(lambda: mouse.n_steps > 300)
    mouse.press("finish")
    table = mouse.tab.locator(".robsim-result table")
    table.wait_for()
    cells = [row.locator("th, td").all_inner_texts() for row in table.locator("tr").all()]
    assert cells[0][:5] == ["Parameter", "True", "Batch", "Std. error", "Online"]
    rows = {row[0]: [number(cell) for cell in row[1:5]] for row in cells[1:]}
    assert list(rows) == list(TRUE_VALUES)
    for name, printed in TRUE_VALUES.items():
        true, batch, error, online = rows[name]
        assert true == pytest.approx(printed, rel=5e-5)
        assert batch == pytest.approx(true, abs=1e-6)
        assert 0 < error < 1e-6
        assert online == pytest.approx(true, abs=1e-3)
    figure = mouse.tab.locator(".robsim-result img")
    assert wait_for(lambda: figure.evaluate("image => image.naturalWidth")) > 400
    said = mouse.tab.inner_text(".robsim-result-remarks")
    assert said.startswith(f"Batch estimate from truth, steps 0..{mouse.n_steps - 1} ")
    assert mouse.tab.get_attribute("main", "data-state") == "paused"


def test_animate_shows_the_running_callback_in_yellow(mouse):
    mouse.choose("Tracking", "Default")
    mouse.choose("Parameter estimation", "Default")
    mouse.open("Callbacks")
    sheet = mouse.tab.locator(".robsim-callbacks")
    once, each = (sheet.locator("section").nth(i).locator(".robsim-slot-name") for i in range(2))
    assert once.count() == 3
    names = each.all_inner_texts()
    order = ["Estimate the state" if i == 3 else name for i, name in enumerate(STEP_ORDER)]
    assert names == [*order, "Control"]
    mouse.tab.evaluate(
        """(() => { window.yellow = [];
        new MutationObserver((all) => { for (const { target } of all)
          if (target.ariaCurrent == "step") yellow.push([
            target.querySelector(".robsim-slot-name").textContent,
            getComputedStyle(target).backgroundColor]); })
        .observe(document.querySelector(".robsim-callbacks"),
          { subtree: true, attributeFilter: ["aria-current"] }); })()"""
    )
    mouse.tab.get_by_role("switch", name="Animate").check()
    mouse.press("start")
    wait_for(lambda: len(mouse.tab.evaluate("yellow")) > 10)
    mouse.press("pause")
    seen = mouse.tab.evaluate("yellow")
    titles = [title for title, _ in seen]
    assert titles[:3] == once.all_inner_texts()
    begin = titles.index("Evaluate the model")
    assert titles[begin : begin + 4] == STEP_ORDER
    for _, color in seen:
        red, green, blue = (float(part) for part in color.removeprefix("color(srgb").split()[:3])
        assert min(red, green) > 0.75
        assert blue < 0.25
    assert mouse.n_steps < 10  # slowly


def test_2_9_boundary_boxes_and_the_measured_heading(mouse):
    mouse.choose("Tracking", "Default")
    mouse.run(170)
    mouse.show("boxes", "object_trace", "path_driven", "outline", "heading_line", on=False)
    step = mouse.view.runner.last_step
    picture = mouse.picture()
    scale = len(picture) / 1200
    boxes = [
        (color, np.array(blob.bounding_box))
        for color, blobs in step.blobs.items()
        for blob in blobs
    ]
    assert [color for color, _ in boxes] == ["blue", "red", "red"]

    def drawn(color, at):
        column, row = np.round(scale * (np.array(at) + 0.5)).astype(int)
        near = picture[row - 2 : row + 3, column - 2 : column + 3]
        return bool((np.abs(near - INKS[color]).max(axis=2) < 50).any())

    def corners():
        return [drawn(color, box[[i, j]]) for color, box in boxes for i in (0, 2) for j in (1, 3)]

    assert not any(corners()[:4])  # of the blue one: the others lie beside what is red anyway
    mouse.show("boxes")
    picture = mouse.picture()
    assert all(corners())
    mouse.show("outline", "heading_line")
    picture = mouse.picture()
    x, y, heading = step.measurement.pose
    along = [
        np.array([x, y]) + r * np.array([math.cos(heading), math.sin(heading)]) for r in (5, 55)
    ]
    assert all(drawn("measured", at) for at in along)
    box = mouse.tab.locator(".robsim-camera > canvas").bounding_box()
    mouse.tab.mouse.move(box["x"] + scale * x, box["y"] + scale * y)
    mouse.paint()
    said = mouse.tab.inner_text(".robsim-camera-readout").replace("\u2212", "-").split("\n")
    assert f"{math.degrees(heading):.1f}\u00b0" in " ".join(said)


def test_2_10_traces_of_the_two_biggest_objects(mouse):
    mouse.choose("Tracking", "Default")
    mouse.run(75)
    x, y = mouse.chart("x px"), mouse.chart("y px")
    assert x.count("blue") == y.count("blue") == 0
    mouse.tab.get_by_label("Objects").check()
    wait_for(lambda: x.count("blue") > 20 and y.count("blue") > 20)
    assert y.count("red") > 40
    part = 0.5
    (k, across), (same, down) = x.read(part), y.read(part)
    assert k == same
    places = {
        name: (number(across[name]), number(down[name])) for name in ("red 1", "red 2", "blue 1")
    }
    red, blue = places["red 2"], places["blue 1"]
    assert places["red 1"] == pytest.approx((600, 92), abs=3)  # the square on the floor
    assert math.dist(red, blue) == pytest.approx(43, abs=1.5)
    assert "blue 2" not in across
    n = wait_for_histograms(mouse)[0][0]
    assert n == mouse.n_steps >= 75


@pytest.mark.parametrize("kind", ["Uniform", "Gaussian"])
def test_2_11_and_2_12_noise_of_40_percent(mouse, kind):
    mouse.choose("Tracking", "Default")
    mouse.choose("Noise", kind)
    mouse.slide("Noise level", 40)
    # robsim finds the robot in spite of this noise; what the figure shows in black is hidden.
    mouse.slide("Dropout", 0.04)
    mouse.run(300)
    noise = mouse.view.runner.noise
    assert (type(noise).__name__, noise.percent) == (f"{kind}Noise", 40)
    trace = mouse.view.record.trace
    held = [mouse.chart(label).count("held") for label in ("x px", "y px", "heading")]
    assert min(held) > 0
    assert 0.8 < trace.seen.mean() < 1
    first = int(np.flatnonzero(trace.seen)[0])
    assert first < 20
    stats = wait_for_histograms(mouse)
    n = stats[0][0]
    assert 20 < n < mouse.n_steps
    # The bell: wider with Gaussian noise of the same level, and wider than without noise.
    low, high = {"Uniform": (0.05, 0.1), "Gaussian": (0.1, 0.15)}[kind]
    assert all(low < std < high for _, _, std in stats[:2])
    error = (trace.pose_measured - trace.pose_true)[trace.seen, :2]
    z = (error - error.mean(0)) / error.std(0)
    assert abs((z**4).mean() - 3) < 0.8  # of a uniform distribution it is 1.8
    # A click on a black dot shows its step, and says why.
    mouse.tab.mouse.click(*mouse.chart("x px").place("held"))
    past = mouse.tab.locator("button[name=past_step]")
    past.wait_for()
    assert not trace.seen[int(past.inner_text().split()[1])]
    badges = mouse.tab.locator(".robsim-camera-badges")
    wait_for(lambda: "Not seen: " in badges.inner_text())
