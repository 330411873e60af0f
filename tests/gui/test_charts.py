"""The traces and the parameters in a browser, with a fake host."""

import base64

import numpy as np
import pytest

from robsim.trace import PARAMETER_NAMES

pytestmark = pytest.mark.slow

TRUE = (214, 33, 156)  # --robsim-true in light
HELD = (0, 0, 0)


def walk(n, seed=16):
    """Return the columns of a robot that drives around, and is lost in ten steps."""
    rng = np.random.default_rng(seed)
    truth = np.array([600, 600, 0]) + np.cumsum(rng.normal(0, [1, 1, 0.02], (n, 3)), axis=0)
    measured = truth + rng.normal(0, [0.5, 0.5, 0.02], (n, 3))
    measured[20:30] = np.nan
    held = measured.copy()
    held[20:30] = measured[19]
    covariance = np.tile(np.diag([0.1, 0.1, 0.001]).ravel(), (n, 1))
    return {
        "pose_true": truth,
        "pose_measured": measured,
        "pose_held": held,
        "pose_estimated": truth + 0.1,
        "covariance": covariance,
    }


def described(**names):
    """Return `setup.columns` of some groups with the names of their fields."""
    return [
        {"name": group, "fields": fields, "units": [""] * len(fields)}
        for group, fields in names.items()
    ]


POSE = ["x", "y", "heading"]
BLOBS = ["x_1", "y_1", "x_2", "y_2"]
COLUMNS = described(
    pose_true=POSE,
    u=["u1", "u2"],
    pose_measured=POSE,
    pose_held=POSE,
    pose_estimated=POSE,
    covariance=[f"c{i}" for i in range(9)],
    parameters=list(PARAMETER_NAMES),
    standard_errors_unscaled=list(PARAMETER_NAMES),
    blobs_red=BLOBS,
    blobs_blue=BLOBS,
)


@pytest.fixture
def show(open_fake):
    """Return a function that shows some rows in a tab."""

    def show_it(rows, tab="traces", setup=None, **options):
        choices = {"tab": tab, "overlays": {"object_trace": False}}  # it asks as well
        host = open_fake(choices=choices, **options)
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


class ChartOf:
    """A chart on the screen, by the beginning of its label."""

    def __init__(self, host, label):
        self.host = host
        self.over = host.tab.locator(f'canvas[aria-label^="{label}"]')

    @property
    def box(self):
        """Left, top, right and bottom of the data in the page: the margins of chart.js."""
        outer = self.over.bounding_box()
        right, bottom = outer["x"] + outer["width"], outer["y"] + outer["height"]
        return outer["x"] + 44, outer["y"] + 22, right - 9, bottom - 8

    def at(self, across, down=0.5):
        left, top, right, bottom = self.box
        return left + across * (right - left), top + down * (bottom - top)

    def point(self, across, down=0.5):
        self.host.tab.mouse.move(*self.at(across, down))
        self.host.paint()

    def pixels(self):
        """Return the data's canvas, uint8 (H, W, 4)."""
        base = self.over.locator("xpath=preceding-sibling::canvas")
        width, height, text = base.evaluate(
            "c => [c.width, c.height, btoa(Array.from(c.getContext('2d')"
            ".getImageData(0, 0, c.width, c.height).data, b => String.fromCharCode(b)).join(''))]"
        )
        return np.frombuffer(base64.b64decode(text), np.uint8).reshape(height, width, 4)

    def inked(self, color):
        """Return where pixels of a colour are: bool (H, W)."""
        pixels = self.pixels().astype(int)
        return (np.abs(pixels[..., :3] - color).max(axis=2) < 40) & (pixels[..., 3] > 200)

    @property
    def says(self):
        return self.over.get_attribute("aria-valuetext") or ""

    def key(self, *keys):
        self.over.focus()
        for key in keys:
            self.host.tab.keyboard.press(key)
        self.host.paint()


def pressed(host):
    return host.tab.locator("button[name=follow]:visible").get_attribute("aria-pressed")


def tip_step(host):
    """Return the step under the pointer, as it is written there."""
    return int(host.tab.locator(".robsim-tip strong").inner_text().split()[1])


def wanted(host):
    return {name for message in host.sent("columns") for name in message["names"]}


def test_only_what_the_visible_tab_needs_is_asked_for_and_painted(show):
    host = show({})
    assert {"pose_true", "pose_measured", "covariance"} <= wanted(host)
    assert not {"parameters", "blobs_red"} & wanted(host)
    host.tab.click("text=Objects")
    settle(host)
    assert {"blobs_red", "blobs_blue"} <= wanted(host)
    host.tab.click("role=tab[name=Parameters]")
    settle(host)
    assert {"parameters", "standard_errors_unscaled"} <= wanted(host)
    host.tab.evaluate(
        "() => { window.painted = 0; const { clearRect } = CanvasRenderingContext2D.prototype;"
        "CanvasRenderingContext2D.prototype.clearRect = function (...box) {"
        "if (this.canvas.closest('.robsim-traces')) painted += 1;"
        "clearRect.apply(this, box); } }"
    )
    host.rows(walk(120))
    host.paint()
    assert host.tab.evaluate("painted") == 0
    host.tab.click("role=tab[name=Traces]")
    settle(host)
    assert host.tab.evaluate("painted") > 0


def test_an_outlier_among_many_rows_is_drawn(show):
    rows = {name: walk(20_000)[name] for name in ("pose_true", "pose_measured")}
    rows["pose_true"][:, 0] = 600 + np.sin(np.arange(20_000) / 1000)
    rows["pose_true"][8642, 0] = 900
    host = show({"pose_true": rows["pose_true"][:10]})
    host.tab.select_option("select[name=window]:visible", "0")
    host.rows(rows)
    settle(host)
    inked = ChartOf(host, "x px").inked(TRUE)
    columns = np.flatnonzero(inked[: inked.shape[0] // 2].any(axis=0))
    assert 1 <= len(columns) <= 2
    left, right = 44, inked.shape[1] - 9
    assert columns[0] == pytest.approx(left + 0.4321 * (right - left), abs=2)


@pytest.mark.parametrize("n", [300, 20_000])
def test_a_heading_that_goes_round_is_broken_not_crossed_out(show, n):
    heading = np.arange(n) / n * 4 * np.pi
    truth = np.column_stack([np.zeros(n), np.zeros(n), np.angle(np.exp(1j * heading))])
    host = show({"pose_true": truth})
    host.tab.select_option("select[name=window]:visible", "0")
    settle(host)
    inked = ChartOf(host, "heading").inked(TRUE)
    middle = inked[22:-22].mean(axis=0)  # of each column
    assert middle.max() < 0.15
    assert (inked[22:-22, 60:-60].any(axis=0)).mean() > (0.9 if n > 300 else 0.5)


def test_wheel_zooms_about_the_pointer_and_holds_and_a_double_click_follows(show):
    host = show(walk(600))
    chart = ChartOf(host, "x px")
    chart.point(0.25)
    before = tip_step(host)
    assert before == pytest.approx(150, abs=1)
    assert pressed(host) == "true"
    for _ in range(8):
        host.tab.mouse.wheel(0, -100)
        host.paint()
    assert pressed(host) == "false"
    chart.point(0.25)
    assert tip_step(host) == pytest.approx(before, abs=1)
    chart.point(0.75)
    assert 160 < tip_step(host) < 250
    host.tab.mouse.dblclick(*chart.at(0.5))
    chart.point(0.5)
    assert pressed(host) == "true"
    assert tip_step(host) == pytest.approx(300, abs=1)


def test_a_drag_pans_all_charts_and_the_values_are_zoomed_on_their_own_axis(show):
    host = show(walk(2000))
    chart, other = ChartOf(host, "x px"), ChartOf(host, "\u0394y")
    before = chart.pixels()
    left, _, _, _ = chart.box
    host.tab.mouse.move(left - 10, chart.at(0, 0.5)[1])
    host.tab.mouse.wheel(0, -300)
    host.paint()
    zoomed = chart.inked(TRUE)
    assert (chart.pixels() != before).any()
    assert pressed(host) == "true"
    host.tab.mouse.dblclick(*chart.at(0.5))
    host.paint()
    assert (chart.inked(TRUE) != zoomed).any()
    host.forget()
    host.tab.mouse.move(*chart.at(0.5))
    host.tab.mouse.down()
    host.tab.mouse.move(*chart.at(0.75), steps=5)
    host.tab.mouse.up()
    host.paint()
    assert host.sent("look") == []
    other.point(0.5)
    # 1400 to 1999 were shown.
    assert tip_step(host) == pytest.approx(1700 - 150, abs=4)


def test_a_click_shows_the_frame_and_one_near_a_black_dot_that_of_the_dot(show):
    rows = walk(100)
    rows["pose_true"][:, 0] = rows["pose_measured"][:, 0] = 600
    rows["pose_measured"][20:30] = np.nan
    rows["pose_held"][:, 0] = 600
    rows["pose_held"][24, 0] = 700
    host = show(rows)
    chart = ChartOf(host, "x px")
    host.tab.mouse.click(*chart.at(0.7))
    assert [message["k"] for message in host.sent("look")] == [70]
    host.forget()
    dot = 22 + np.flatnonzero(chart.inked(HELD)[22:].any(axis=1))[0]  # the highest one
    outer = chart.over.bounding_box()
    host.tab.mouse.click(chart.at(0.255)[0], outer["y"] + float(dot) + 3)
    assert [message["k"] for message in host.sent("look")] == [24]


def test_keys_move_the_cursor_and_say_what_is_there(show):
    host = show(walk(600))
    chart = ChartOf(host, "x px")
    chart.key("End")
    assert chart.says.startswith("step 599 ")
    chart.key("ArrowLeft", "Shift+ArrowLeft")
    assert chart.says.startswith("step 588 ")
    assert "measured" in chart.says
    chart.key("Home", "ArrowRight")
    assert chart.says.startswith("step 1 ")
    chart.key("Enter")
    assert [message["k"] for message in host.sent("look")] == [1]
    chart.key("+")
    assert pressed(host) == "false"
    chart.key("Escape")
    assert pressed(host) == "true"
    assert [message["k"] for message in host.sent("look")] == [1, None]


def test_any_column_can_be_added_and_is_kept_and_a_layer_taken_away(show):
    host = show(walk(100))
    chart = ChartOf(host, "x px")
    assert chart.inked(TRUE).any()
    host.tab.click("button[name=show_true]")
    host.paint()
    assert not chart.inked(TRUE).any()
    host.tab.select_option("select[name=add_column]", "u2")
    host.rows({"u": np.ones((100, 2))})
    settle(host)
    assert "u" in wanted(host)
    ChartOf(host, "u2").key("End")
    assert "u2 1.000" in ChartOf(host, "u2").says
    host.load()
    host.setup(columns=COLUMNS)
    host.state()
    settle(host)
    assert ChartOf(host, "u2").over.is_visible()
    host.tab.click("button[name=remove_u2]")
    assert ChartOf(host, "u2").over.count() == 0


def test_after_a_reset_nothing_old_is_left(show):
    host = show(walk(500))
    chart = ChartOf(host, "x px")
    chart.point(0.5)
    assert chart.inked(TRUE).any()
    host.rows({name: block[:0] for name, block in walk(50).items()})
    host.paint()
    assert not chart.inked(TRUE).any()
    assert host.tab.locator(".robsim-tip").is_hidden()
    host.rows(walk(50, seed=2))
    host.paint()
    assert chart.inked(TRUE).any()


def test_without_truth_the_inputs_stand_in_place_of_the_errors(show):
    rows = walk(100)
    del rows["pose_true"]
    host = show(rows | {"u": np.ones((100, 2))}, setup={"has_truth": False})
    assert "u" in wanted(host)
    assert ChartOf(host, "\u0394x").over.count() == 0
    for label in ("u1", "u2", "interval"):
        assert ChartOf(host, label).over.is_visible()
    assert host.tab.locator("button[name=show_measured]").is_visible()
    assert host.tab.locator("button[name=show_true]").is_hidden()
    host.tab.click("button[name=show]")
    assert host.tab.locator("input[name=show_outline]").is_visible()
    assert host.tab.locator("input[name=show_truth]").count() == 0


def test_histograms_stand_beside_the_errors_and_in_a_low_chart_beside_their_numbers(show):
    host = show(walk(200))
    count = "c => new Set(c.getContext('2d').getImageData(0, 0, c.width, c.height).data).size"
    ends = """c => { // of the bars and of the canvas
      const { data } = c.getContext("2d").getImageData(0, 0, c.width, c.height);
      const isBar = (x) => {
        let n = 0;
        for (let y = 0; y < c.height; y++) n += data[4 * (y * c.width + x) + 3] == 102;
        return n > c.height / 4;
      };
      const barred = [...Array(c.width).keys()].filter(isBar);
      return [Math.max(...barred), c.width];
    }"""
    histogram = host.tab.locator(".robsim-histogram").first
    before = histogram.evaluate(count)
    bars = {"n": 170, "mean": 0.0, "std": 0.5, "low": -9.0, "high": 9.0, "counts": [9] * 18}
    errors = [{"of": "measurement", "name": "x", "unit": "px", **bars}]
    host.emit({"type": "statistics", "first": 30, "last": 199, "errors": errors})
    host.paint()
    assert histogram.evaluate(count) > before
    last, wide = histogram.evaluate(ends)
    host.tab.set_viewport_size({"width": 800, "height": 600})
    settle(host)
    last_low, wide_low = histogram.evaluate(ends)
    assert last_low == last > 30
    assert wide_low > wide + 60
    host.emit({"type": "statistics", "first": None, "last": None, "errors": []})
    host.paint()
    assert histogram.evaluate(ends)[0] is None or histogram.evaluate(count) <= before


def test_parameters_are_drawn_with_truth_excitation_and_a_robust_range(show):
    rng = np.random.default_rng(3)
    values = 1.9 + rng.normal(0, 0.01, (600, 15))
    values[:5] = 1e5
    spread = np.tile(1 / np.sqrt(1 + np.arange(600))[:, np.newaxis], (1, 15))
    rows = {"parameters": values, "standard_errors_unscaled": spread}
    host = show(rows, "parameters", {"theta_true": [1.9375] * 15})
    host.emit(
        {
            "type": "parameters",
            "names": list(PARAMETER_NAMES),
            "values": values[-1].tolist(),
            "errors": [0.01] * 15,
            "excitation": {"text": "b1 is hardly excited", "good": False, "weak": ["b1X"]},
        }
    )
    settle(host)
    chart = ChartOf(host, "a1X")
    assert host.tab.locator("canvas[role=slider]:visible").count() == 15
    assert host.tab.locator(".robsim-verdict").inner_text() == "b1 is hardly excited"
    assert chart.inked(TRUE).sum() > 20
    line = chart.inked((31, 111, 235))
    assert np.flatnonzero(line[22:].any(axis=1)).size > 40  # not squashed by the first steps
    chart.key("End")
    assert "\u00b1 0.010" in chart.says
    weak, good = ChartOf(host, "b1X"), ChartOf(host, "b1Y")
    warning = (138, 90, 0)
    assert weak.inked(warning).sum() > good.inked(warning).sum() == 0
