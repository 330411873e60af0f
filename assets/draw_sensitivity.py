"""How exact the identified parameters get, by each setting of a run: ./run study sensitivity.

A campaign for each setting, all others being those of `BASE`; the runs of all campaigns have the
same seeds. Draws notebooks/site/sensitivity.png, and prints the numbers.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from PIL import Image

import robsim
from robsim.plotting import style as style
from robsim.trace import PARAMETER_NAMES

FIGURE = Path(__file__).parents[1] / "notebooks/site/sensitivity.png"
RUNS, STEPS, SEED = 24, 400, 1

BASE = robsim.Scenario(
    robot="lab",
    resolution=(480, 480),
    headings=None,
    boundary="unlimited",
    control=robsim.DriveAround(),
    measure=True,
    noise=robsim.GaussianNoise(5),
    identify_from="measurement",
)
METHOD = "output_error"

#: Name, colour, mark, parameters and what their errors are relative to, of the lines of a panel:
#: a1 relative to 2 - a1, the share of its speed that the robot loses in a step.
GROUPS = {
    "input to place: b1X, b2X, b1Y, b2Y": ("#1f5fe0", "o", ("b1X", "b2X", "b1Y", "b2Y")),
    "input to heading: b1P, b2P": ("#e07b00", "s", ("b1P", "b2P")),
    "friction in driving: 2 - a1X, 2 - a1Y": ("#5fa8f5", "^", ("a1X", "a1Y")),
    "friction in turning: 2 - a1P": ("#f0b060", "v", ("a1P",)),
}
_NAMES = tuple(name for *_, names in GROUPS.values() for name in names)
_AT = [PARAMETER_NAMES.index(name) for name in _NAMES]

#: Errors that many times as large as the standard errors say are drawn hollow.
DISHONEST = 4.0
_LIMITS = (0.004, 150.0)  # %
_BASE_WIDTH = 9  # points


def _errors(theta: Any, true: Any, standard_errors: Any) -> dict[str, float]:
    """Return relative errors (%), and errors over their standard errors, by parameter."""
    size = np.abs(np.where(np.arange(5) == 0, 2 - true, true))
    with np.errstate(divide="ignore", invalid="ignore"):  # d1 is 0
        relative = (100 * (theta - true) / size).ravel()[_AT]
        z = ((theta - true) / standard_errors).ravel()[_AT]
    return {
        **{f"error_{name}": value for name, value in zip(_NAMES, relative, strict=True)},
        **{f"z_{name}": value for name, value in zip(_NAMES, z, strict=True)},
    }


def fitted(trace: robsim.Trace, *, steps: int | None = None, **options: Any) -> dict[str, float]:
    """Return the errors of a batch estimate from the first steps."""
    fit = robsim.batch_estimate(trace[:steps], **{"method": METHOD} | options)
    # A fit for measurement noise alone has these, least squares has not.
    white = np.isfinite(fit.white_noise_errors)
    errors = np.where(white, fit.white_noise_errors, fit.standard_errors)
    return _errors(fit.batch, fit.theta_true, errors)


def recursive(trace: robsim.Trace) -> dict[str, float]:
    """Return the errors of the last online estimate, which has no standard errors."""
    return _errors(trace.parameters[-1], np.array(trace.info.theta_true), np.full((3, 5), np.inf))


def least_squares(model: robsim.RobotModel, *, forgetting: float) -> Any:
    """Return what estimates the parameters online."""
    return robsim.RecursiveLeastSquares(5, n_filters=3, forgetting=forgetting)


@dataclass(frozen=True, kw_only=True)
class Setting:
    """A setting, its values, and which of them is that of `BASE`.

    The values are those of options of the simulation, or, without any, of the fit: then there is a
    metric for each.
    """

    label: str
    base: str = ""
    vary: Mapping[str, Any] = field(default_factory=dict)
    metrics: Mapping[str, Any] = field(default_factory=lambda: {"fit": fitted})
    scenario: robsim.Scenario = BASE
    steps: int = STEPS


def _disturbed(sigma: float) -> robsim.PoseNoise:
    return robsim.PoseNoise.from_sigma(sigma, sigma, sigma / 20)


_METHODS = {
    "least squares": partial(fitted, method="least_squares"),
    "instrum. variables": partial(fitted, method="instrumental_variables"),
    "output error": partial(fitted, method="output_error"),
}
_DELAYS = {delay: delay for delay in (0, 0.1, 0.25, 0.5, 1, 2)}

SETTINGS: dict[str, Setting] = {
    "camera noise": Setting(
        label="Gaussian, %",
        base="5",
        vary={"noise": {p: robsim.GaussianNoise(p) for p in (0, 1, 2, 5, 10, 20, 40)}},
    ),
    "resolution": Setting(
        label="px across the area",
        base="480",
        vary={"resolution": {n: (n, n) for n in (240, 320, 480, 720, 1200)}},
    ),
    "drawn headings": Setting(
        label="number of headings",
        base="any",
        vary={"headings": {"36": 36, "72": 72, "180": 180, "360": 360, "any": None}},
    ),
    "lost frames": Setting(
        label="share hidden",
        base="0",
        vary={"dropout": {p: robsim.Dropout(p) for p in (0, 0.1, 0.2, 0.4, 0.6)}},
    ),
    "voltages": Setting(
        label="times -0.5 to 1.5 V",
        base="1",
        vary={
            "control": {
                s: robsim.DriveAround(low=-0.5 * s, high=1.5 * s) for s in (0.1, 0.25, 0.5, 1, 2)
            }
        },
    ),
    "hold of a voltage": Setting(
        label="steps",
        base="10",
        vary={"control": {n: robsim.DriveAround(hold=n) for n in (1, 3, 10, 30, 100)}},
    ),
    "time between steps": Setting(
        label="dt, s (400 steps)",
        base="0.2",
        vary={
            "model": {dt: robsim.RobotParameters(dt=dt) for dt in (0.05, 0.1, 0.2, 0.4, 0.8)},
        },
    ),
    "length of the run": Setting(
        label="steps",
        base="400",
        metrics={f"{n}": partial(fitted, steps=n) for n in (50, 100, 200, 400, 800, 1600)},
        steps=1600,
    ),
    "disturbance": Setting(
        label="px in each step",
        base="0",
        vary={"process_noise": {s: _disturbed(s) for s in (0, 0.001, 0.01, 0.1, 0.3)}},
    ),
    "walls, start": Setting(
        label="",
        base="none, centre",
        vary={
            "boundary": {"none,": "unlimited", "walls,": "bounce"},
            "start": {"centre": (600, 600, 0), "random": "random"},
        },
    ),
    "late inputs, not told": Setting(
        label="motor delay, steps", base="0", vary={"motor_delay": _DELAYS}
    ),
    "late inputs, fitted": Setting(
        label="motor delay, steps",
        vary={"motor_delay": _DELAYS},
        metrics={"fit": partial(fitted, motor_delay="fit")},
    ),
    "method": Setting(label="", base="output error", metrics=_METHODS),
    "method, disturbed": Setting(
        label="0.1 px in each step",
        metrics=_METHODS,
        scenario=BASE.replace(process_noise=_disturbed(0.1)),
    ),
    "smoothing": Setting(
        label="window, px; at 40 % noise",
        vary={"smoothing": {"default": None, "1": 1, "3": 3, "5": 5, "9": 9}},
        scenario=BASE.replace(noise=robsim.GaussianNoise(40)),
    ),
    "forgetting": Setting(
        label="recursive least squares",
        vary={
            "init_parameter_estimator": {
                f"{forgetting:g}": partial(least_squares, forgetting=forgetting)
                for forgetting in (1, 0.999, 0.99, 0.95, 0.9)
            }
        },
        metrics={"fit": recursive},
        scenario=BASE.replace(estimate_parameters=True),
    ),
}


class Errors(NamedTuple):
    """Of the values of a setting, by group: median error (%), and how honest it is, (groups, N)."""

    values: tuple[str, ...]
    error: np.ndarray
    over_standard_error: np.ndarray


def errors_of(
    name: str,
    *,
    runs: int = RUNS,
    executor: int | None = None,
    keep: Path | None = None,
) -> Errors:
    """Run the campaign of a setting, and return its errors."""
    setting = SETTINGS[name]
    result = robsim.campaign(
        setting.scenario,
        vary=setting.vary,
        metrics=setting.metrics,
        runs=runs,
        steps=setting.steps,
        seed=SEED,
        executor=executor,
        store=keep and keep / f"{name}.sqlite",
        on_error="raise",
    )
    columns = [(case, metric) for case in result.spec.cases for metric in setting.metrics]
    if setting.vary:
        values = tuple(" ".join(map(str, case.labels.values())) for case, _ in columns)
    else:
        values = tuple(setting.metrics)
    error, z = (
        np.array(
            [
                [_median(result, case.index, f"{metric}_{kind}", group) for case, metric in columns]
                for group in GROUPS
            ]
        )
        for kind in ("error", "z")
    )
    # The median of |z| of a normal distribution is 0.6745.
    return Errors(values, error, z / 0.6745)


def _median(result: robsim.campaigns.CampaignResult, case: int, column: str, group: str) -> float:
    """Return the median size of a number over runs and parameters; what is not known is large."""
    rows = result["case_id"] == case
    sizes = np.abs([result[f"{column}_{name}"][rows] for name in GROUPS[group][2]])
    return float(np.median(np.where(np.isnan(sizes), np.inf, sizes)))


@style.applied
def figure_of(found: Mapping[str, Errors]) -> Figure:
    """Return the figure: a panel for each setting."""
    columns = min(4, len(found))
    rows = -(-len(found) // columns)
    figure = style.NotebookFigure(figsize=(2.75 * columns, 2.35 * rows + 0.6))
    panels = figure.subplots(rows, columns, sharey=True, squeeze=False)
    for axes, (name, errors) in zip(panels.flat, found.items(), strict=False):
        _draw(axes, name, errors)
    for axes in panels[:, 0]:
        axes.set_ylabel("median error (%)")
    handles, _ = panels[0, 0].get_legend_handles_labels()
    base = Line2D(
        [], [], color=style.REPORTED, linewidth=_BASE_WIDTH, label="as in all other panels"
    )
    text = f"hollow: over {DISHONEST:g} x what the standard errors say"
    hollow = Line2D([], [], linestyle="", marker="o", label=text, **_hollow(style.FITTED))
    figure.legend(handles=[*handles, hollow, base], loc="outside lower center", ncols=3)
    return figure


def _hollow(color: str) -> dict[str, Any]:
    """Return the look of a mark whose standard errors are not honest."""
    look = {"markerfacecolor": "white", "markeredgecolor": color}
    return look | {"markeredgewidth": 1.2, "markersize": 5}


def _draw(axes: Axes, name: str, errors: Errors) -> None:
    setting, x = SETTINGS[name], np.arange(len(errors.values))
    if setting.base in errors.values:
        base = errors.values.index(setting.base)
        axes.axvline(base, color=style.REPORTED, linewidth=_BASE_WIDTH, zorder=0)
    for group, error, ratio in zip(GROUPS, errors.error, errors.over_standard_error, strict=True):
        color, mark, _ = GROUPS[group]
        shown = np.clip(error, *_LIMITS)
        axes.plot(x, shown, "-", marker=mark, color=color, markersize=5, linewidth=1.2, label=group)
        hollow = np.isfinite(ratio) & (ratio > DISHONEST)
        axes.plot(x[hollow], shown[hollow], mark, **_hollow(color))
    axes.set(yscale="log", ylim=_LIMITS, xlim=(-0.5, len(x) - 0.5), xlabel=setting.label)
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_xticks(x, [value.replace(" ", "\n") for value in errors.values])
    axes.set_title(name, loc="left")


def table(name: str, errors: Errors) -> str:
    """Return the numbers: errors (%), in brackets in units of what the standard errors say."""
    lines = [f"{name:24}" + "".join(f"{value:>20}" for value in errors.values)]
    for group, error, ratio in zip(GROUPS, errors.error, errors.over_standard_error, strict=True):
        cells = [f"{e:.2g} ({f'{r:.1f}' if r else '-'})" for e, r in zip(error, ratio, strict=True)]
        lines.append(f"  {group.partition(':')[0]:22}" + "".join(f"{cell:>20}" for cell in cells))
    return "\n".join(lines) + "\n"


def main() -> int:
    """Run the campaigns, draw the figure, print the numbers."""
    parser = argparse.ArgumentParser(
        prog="./run study sensitivity", description=__doc__.split("\n")[0]
    )
    parser.add_argument("--runs", type=int, default=RUNS, help=f"default: {RUNS}")
    parser.add_argument("--only", nargs="+", choices=SETTINGS, default=list(SETTINGS))
    parser.add_argument("--jobs", type=int, help="processes; default: this one")
    parser.add_argument("--keep", type=Path, help="keep what is done in this folder, and go on")
    parser.add_argument("--out", type=Path, default=FIGURE, help="the figure; default: the page's")
    given = parser.parse_args()
    if given.keep:
        given.keep.mkdir(parents=True, exist_ok=True)
    found = {}
    for name in given.only:
        found[name] = errors_of(name, runs=given.runs, executor=given.jobs, keep=given.keep)
        print(table(name, found[name]), flush=True)
    from draw_readme import picture

    image = picture(figure_of(found))
    image.quantize(128, dither=Image.Dither.NONE).save(given.out, optimize=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
