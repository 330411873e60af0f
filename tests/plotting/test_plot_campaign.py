"""`plot_campaign`: bands and boxes."""

import numpy as np
import pytest

import robsim
from robsim.campaigns import campaign
from robsim.plotting import plot_campaign


@pytest.fixture(scope="module")
def result():
    return campaign(
        robsim.Scenario(area=(300, 300), start="random"),
        vary={
            "motor_delay": {3: 3, 0: 0, 1.5: 1.5},
            "control": {"$fast": robsim.Spin(0.9), "slow": robsim.Spin(0.1)},
        },
        metrics={"x": lambda trace: trace.pose_true[-1, 2]},
        runs=8,
        steps=20,
        seed=1,
        progress=False,
    )


@pytest.mark.long
def test_bands_are_means_over_an_option_with_their_intervals(result):
    ax = plot_campaign(result, "x", over="motor_delay")
    table = result["x"].reshape(3, 2, 8)[[1, 2, 0]]  # by rising delay
    assert len(ax.lines) == 2
    for control, line in enumerate(ax.lines):
        assert line.get_xdata().tolist() == [0, 1.5, 3]
        np.testing.assert_allclose(line.get_ydata(), table[:, control].mean(axis=1))
    assert [text.get_text() for text in ax.get_legend().get_texts()] == [r"\$fast", "slow"]
    half = result.summary(("motor_delay", "control")).half_width[2, 0]
    heights = np.ptp(ax.collections[0].get_paths()[0].vertices[:, 1])
    assert heights >= 2 * half
    ax.figure.canvas.draw()


def test_boxes_have_the_quartiles_of_each_case(result):
    ax = plot_campaign(result, "x")
    medians = [line for line in ax.lines if line.get_color() == "#1f5fe0"]
    expected = np.median(result["x"].reshape(6, 8), axis=1)
    np.testing.assert_allclose([line.get_ydata()[0] for line in medians], expected)
    assert [text.get_text() for text in ax.get_xticklabels()][1] == "3\nslow"
    ax.figure.canvas.draw()


def test_long_labels_do_not_cover_each_other():
    noise = [robsim.GaussianNoise(percent) for percent in (1, 2, 5, 10, 20)]
    result = campaign(
        robsim.Scenario(area=(300, 300), start="random"),
        vary={"noise": noise},
        metrics={"x": lambda trace: trace.pose_true[-1, 0]},
        runs=2,
        steps=2,
        progress=False,
    )
    labels = plot_campaign(result, "x").get_xticklabels()
    assert {label.get_rotation() for label in labels} == {30}


def test_failed_runs_leave_gaps():
    def fails(trace):
        raise ValueError

    nothing = campaign(metrics={"x": fails}, runs=2, steps=2, progress=False)
    with pytest.raises(ValueError, match="no numbers to draw: all runs failed"):
        plot_campaign(nothing, "x")


def test_what_cannot_be_drawn_is_refused(result):
    with pytest.raises(ValueError, match=r"\bmetric\b"):
        plot_campaign(result, "y")
    with pytest.raises(ValueError, match="control"):  # its values are no numbers
        plot_campaign(result, "x", over="control")
