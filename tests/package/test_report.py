"""The one kind of result: a metric of one's own, and what all results have in common."""

import json
import sys
import textwrap
from dataclasses import dataclass

import numpy as np
import pytest

import robsim
from robsim.estimation import Column, Quantity, Report, Row, Table, percent

NAN = float("nan")


# A metric of one's own.


@dataclass(frozen=True, kw_only=True, eq=False)
class Effort(Report):
    """How hard the motors worked."""

    rms: float
    each: np.ndarray
    names: tuple = ("left", "right")
    turn: float = 0.0

    @property
    def title(self):
        return "Voltages of the motors"

    @property
    def verdict(self):
        return "gentle" if self.rms < 1 else "rough"

    @property
    def quantities(self):
        return (
            Quantity("rms", "root mean square", self.rms, "V", ".2f"),
            Quantity("turn", "turned by", self.turn, "rad", ".1f"),
        )

    @property
    def tables(self):
        columns = [Column("mean", "mean", "V"), Column("share", "of the power", format=percent)]
        rows = [Row(name, values) for name, values in zip(self.names, self.each, strict=True)]
        return [Table(key="motors", columns=columns, rows=rows, row_title="motor")]

    @property
    def remarks(self):
        return ["the voltages are those sent"]


EFFORT = Effort(rms=np.float64(0.5), each=np.array([[0.25, 0.75], [NAN, 0.25]]), turn=np.pi / 2)


def test_a_metric_as_text():
    assert str(EFFORT) == textwrap.dedent("""\
        Voltages of the motors: gentle
          root mean square (V)   0.50
          turned by (deg)        90.0

          motor   mean (V)   of the power
          -------------------------------
          left        0.25         75.0 %
          right          -         25.0 %
          - the voltages are those sent""")
    line = "Voltages of the motors: gentle, root mean square 0.50 V, turned by 90.0 deg"
    assert EFFORT.line == line
    assert repr(EFFORT) == f"<Effort: {line}>"


def test_a_metric_as_data():
    expected = {
        "title": "Voltages of the motors",
        "verdict": "gentle",
        "rms": 0.5,
        "turn": np.pi / 2,
        "motors": {"left": {"mean": 0.25, "share": 0.75}, "right": {"mean": None, "share": 0.25}},
        "units": {"rms": "V", "turn": "rad", "motors": {"mean": "V"}},
        "remarks": ["the voltages are those sent"],
    }
    assert EFFORT.to_dict() == expected
    assert type(EFFORT.to_dict()["rms"]) is float
    assert json.loads(EFFORT.to_json()) == json.loads(EFFORT.to_json(indent=None)) == expected


def test_a_metric_as_a_data_frame(monkeypatch):
    frame = EFFORT.to_pandas()
    assert frame.index.name == "motor"
    assert frame.loc["left", "mean"] == 0.25
    assert frame["mean"].dtype == np.float64
    assert frame.attrs == {"title": "Voltages of the motors", "verdict": "gentle"}
    # Without a table a row for each quantity.
    frame = robsim.Simulation(measure=True, seed=1).run(2).tracking().to_pandas()
    assert frame.loc["seen", "value"] == 2
    assert frame.loc["rmse_xy", "unit"] == "px"
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match="pip install pandas"):
        EFFORT.to_pandas()


def test_a_metric_in_a_notebook():
    html = EFFORT._repr_html_()
    assert html.count("<table") == html.count("</table>") == 2
    for text in ("Voltages of the motors: gentle", "mean (V)", "75.0 %", "voltages are those sent"):
        assert text in html
    assert "color" not in html  # the notebook's own, light or dark


def test_every_text_is_escaped():
    evil = "<script>alert(1)</script>"
    names = Effort(rms=2.0, each=np.ones((1, 2)), names=(evil,))
    units = robsim.estimation.estimation_errors(
        np.ones((1, 1)), np.zeros((1, 1)), names=[evil], units=[evil], source=evil
    )
    problem = robsim.teach.Problem(kind="a", sentence=evil)
    check = robsim.teach.CheckReport(name=evil, problems=(problem,), remarks=(evil,))
    for result in (names, units, check):
        assert "<script" not in result._repr_html_()
        assert "&lt;script&gt;" in result._repr_html_()


def test_a_field_that_hides_a_property_is_told():
    with pytest.raises(TypeError, match="title"):
        type("Untitled", (Report,), {})()
    with pytest.raises(TypeError, match=r"Mine\.title"):

        class Mine(Report):
            title: str

    @dataclass(frozen=True)
    class Fine(Report):
        title: str = "fine"

    assert str(Fine("good")) == "good"


def test_only_all_is_100_percent_and_only_nothing_0():
    for fraction, text in {
        0: "0 %",
        1: "100 %",
        0.75: "75.0 %",
        199_998 / 200_000: "99.999 %",
        2 / 200_000: "0.001 %",
        0.9995: "99.95 %",
        0.0004: "0.04 %",
        1 - 1e-9: "> 99.999 %",
        1e-9: "< 0.001 %",
        1 + 1e-9: "> 100 %",
        1.5: "150.0 %",
        1e6: "> 1000 %",
    }.items():
        assert percent(fraction) == text
    # Fewer decimals where they are enough.
    assert (percent(0.05, 0), percent(0.998, 0)) == ("5 %", "99.8 %")


# All results.


@pytest.fixture(scope="module")
def results():
    sim = robsim.Simulation(
        boundary="unlimited",
        control=robsim.DriveAround(),
        estimate_parameters=True,
        measure=True,
        seed=1,
    )
    trace = sim.run(60)
    ones = np.ones((5, 8, 2))
    blue = robsim.load_colors()[1]
    return [
        trace.tracking(),
        trace.summary(),
        robsim.batch_estimate(trace),
        robsim.identifiability(trace),
        robsim.estimation.parameter_convergence(trace),
        robsim.estimation.output_error(trace.pose_measured, trace.u),
        robsim.pose_errors(trace, of="measurement"),
        robsim.estimation.nees_consistency(ones, np.eye(2)),
        robsim.estimation.nis_consistency(ones, np.eye(2)),
        robsim.estimation.whiteness(ones, lags=3),
        robsim.score_path(trace, [(700, 600)]),
        robsim.vision.score_color(sim.frame, blue, [(5, 5, 9, 9)], repeats=1),
        robsim.vision.check_colors(sim.robot),
    ]


@pytest.mark.long
def test_every_result_has_every_form(results):
    for result in results:
        assert isinstance(result, Report), result
        lines = str(result).splitlines()
        assert lines[0] == result.headline
        assert max(map(len, lines)) <= 100
        assert len(repr(result)) <= 110
        assert "\n" not in repr(result)
        assert result.headline in result._repr_html_()
        assert json.loads(result.to_json()) == result.to_dict()
        assert result.to_dict()["title"] == result.title
        result.to_pandas()
        assert result.verdict is None or len(result.verdict.split()) <= 2
